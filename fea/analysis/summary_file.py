"""The file of a run's figures: its name and its format."""

SUMMARY = "summary.json"
SCHEMA = "fea/summary/1"
