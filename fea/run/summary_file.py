"""The file of a run's figures: its name and its format."""

SUMMARY = "summary.json"
SCHEMA = "fea/summary/1"
# Those of a search for the lightest rod.
OPTIMISED = "optimise.json"
OPTIMISED_SCHEMA = "fea/optimise/1"
