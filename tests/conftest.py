"""What holds for all tests."""

from hypothesis import settings

# The same examples every time, and no clock: a test that fails today failed yesterday.
# `--hypothesis-profile default` looks for new ones.
settings.register_profile("repeatable", derandomize=True, deadline=None)
settings.load_profile("repeatable")
