"""The job behind `fea studio`: the session, the processes and the server, until it is interrupted."""

import asyncio
from collections.abc import Callable
from pathlib import Path

from fea.apps.studio.access import Access
from fea.apps.studio.jobs import MODEL, open_live, open_worker
from fea.apps.studio.server import Studio, serve_studio
from fea.apps.studio.session import State, session
from fea.apps.studio.worker import Worker
from fea.output.studio.page import studio_page
from fea.output.target import near
from fea.study.study import Study
from geometry.system import saying


def run_studio(
    study: Study, folder: Path, port: int, opened: Callable[[str], None], model: str = MODEL
) -> None:
    """Serve the page of a study until an interrupt; `opened` is told its address.

    Raises
    ------
    OccupiedError, StorageError
        The session cannot be kept in the folder.
    OSError
        The port is taken.
    """
    page, policy = studio_page(study.name)
    said = f"the studio has ended; the same command resumes its session in {near(folder)}"
    first: State = {"design": {}, "operation": {}}  # of the study: nothing is changed
    with saying(said), session(study, first, folder) as kept:
        live, fresh = Worker(open_live, study, model), Worker(open_worker, study, model)
        served = Studio(kept, folder, live, fresh)
        asyncio.run(serve_studio(served, Access(port, page, policy), opened))
