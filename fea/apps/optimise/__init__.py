"""The lightest rod that holds: free dimensions, what limits them, and the search between."""
