"""How fast a rod can turn and how much gas pressure it stands: a map of speed and peak pressure."""
