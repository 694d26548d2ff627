"""Silence for the CAD kernel, which writes to standard output itself."""

import os
import sys
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager


@contextmanager
def quiet() -> Iterator[None]:
    """Keep the kernel's own messages off standard output, where they would spoil `--json`."""
    sys.stdout.flush()
    kept = os.dup(1)
    try:
        with tempfile.TemporaryFile() as drain:
            os.dup2(drain.fileno(), 1)
            yield
    finally:
        os.dup2(kept, 1)
        os.close(kept)
