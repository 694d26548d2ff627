"""The lightest rod that meets the required factors: free dimensions, constraints, and the search between."""
