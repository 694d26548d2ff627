"""The benchmark problems of `fea verify`, one module per kind."""
