"""The benchmark problems of `fea verify`, a module a kind."""
