"""`fea studio`."""

import sys
from importlib.util import find_spec
from pathlib import Path

from fea.cli.options import FILE_FLAGS, StudyName, Threads, takes
from fea.study.flags import NO_FLAGS, Flags
from fea.study.study import DEFAULT_STUDY, load_study
from geometry.errors import require

_LARGEST_PORT = 65_535


@takes("engine", "material", "rpm", "pressure", "size", "tolerance", *FILE_FLAGS)
def studio(
    study: StudyName = DEFAULT_STUDY,
    *,
    flags: Flags = NO_FLAGS,
    port: int = 0,
    no_browser: bool = False,
    threads: Threads = None,
) -> None:
    """Change a rod in the browser and see at once what it does to mass, stress and safety factors.

    Parameters
    ----------
    port
        Port of the page on this machine, which nobody else can open; default: any that is free.
    no_browser
        Print the address of the page, but do not open it.
    """
    from fea.machine.threads import limit_threads

    limit_threads(threads)
    require(0 <= port <= _LARGEST_PORT, "--port", port, f"must lie between 0 and {_LARGEST_PORT}")
    asked = flags.applied(load_study(study))
    asked.require_loading()

    if find_spec("websockets") is None:
        raise ImportError("fea studio needs websockets, not installed here: pip install websockets")
    from fea.apps.studio.run_studio import run_studio

    def opened(address: str) -> None:
        sys.stdout.write(f"{address}\n")
        sys.stdout.flush()
        if not no_browser:
            import webbrowser

            webbrowser.open(address)

    run_studio(asked, Path("results") / f"{asked.name}-studio", port, opened)
