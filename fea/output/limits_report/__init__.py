"""The page of `fea limits`."""
