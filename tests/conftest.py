"""What holds for all tests."""

import signal

from hypothesis import settings

# The same examples every time, and no clock: a test that fails today failed yesterday.
# `--hypothesis-profile default` looks for new ones.
settings.register_profile("repeatable", derandomize=True, deadline=None)
settings.load_profile("repeatable")

# Who starts the tests in the background may have told them to ignore Ctrl-C; those that send it need it.
signal.signal(signal.SIGINT, signal.default_int_handler)
