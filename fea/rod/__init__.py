"""The meshed rod of a study, and what loads it."""
