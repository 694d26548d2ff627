"""`fea run` as a whole process, and the same process when it only imports what that run imports.

python imports.py run LIST FLAGS…    runs `fea run FLAGS…` and leaves the names of its modules in LIST
python imports.py floor LIST         imports them
"""

import contextlib
import importlib
import sys
from pathlib import Path


def main() -> None:
    what, names, *flags = sys.argv[1:]
    if what == "run":
        from fea.__main__ import main as fea

        sys.argv = ["fea", "run", *flags]
        try:
            fea()
        finally:
            Path(names).write_text("\n".join(list(sys.modules)), encoding="utf-8")
        return
    for name in Path(names).read_text(encoding="utf-8").splitlines():
        with contextlib.suppress(Exception):  # what a module makes up by itself comes with it
            importlib.import_module(name)


if __name__ == "__main__":
    main()
