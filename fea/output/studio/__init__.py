"""The page of `fea studio`."""
