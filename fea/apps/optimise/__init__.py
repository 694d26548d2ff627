"""The lightest rod that meets the required factors: free dimensions, limits, and the search between."""
