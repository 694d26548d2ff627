"""The signals that ask a program to end."""

import signal

# Ctrl-C, `kill` or a batch system whose time is up, a terminal that was closed.
ENDS = tuple(getattr(signal, name) for name in ("SIGINT", "SIGTERM", "SIGHUP") if hasattr(signal, name))
