"""The server of `fea studio`: it passes on what the page asks and what two processes answer.

The page numbers what it asks. An answer carries that number and the design that it is of, in one message
with its picture; a request that is not answered yet is dropped when another comes.
"""

import asyncio
import json
import logging
from collections.abc import Awaitable, Callable, Mapping
from contextlib import suppress
from dataclasses import dataclass
from functools import partial
from math import isfinite
from pathlib import Path
from typing import Any

from websockets.asyncio.server import ServerConnection, serve
from websockets.exceptions import ConnectionClosed

from fea.apps.studio import jobs
from fea.apps.studio.access import Access
from fea.apps.studio.session import KNOWN, Session, State
from fea.apps.studio.worker import Worker
from fea.machine.isolated import CrashError

# Times that a process may end over one request before it is given up.
_MOST_CRASHES = 2
_LONGEST_MESSAGE = 2**16  # bytes, from the page
_LONGEST_NAME = 60
_MESHES = 4  # that are kept for a page that is loaded again
_REPLACED = 4000  # why a socket is closed (of the range for applications)
_CONVERGING = "converge"


@dataclass(frozen=True)
class Asked:
    """A design that the page asks about."""

    serial: int
    state: State
    rests: bool = True  #: whether the hand rests: exact answers are wanted, too
    touched: str = ""  #: the dimension that is being changed
    field: str = "von_mises"  #: what the picture shows


class Studio:
    """One page, its session, and the two processes that compute for it."""

    def __init__(self, session: Session, folder: Path, live: Worker, fresh: Worker) -> None:
        self._session, self._folder, self._live, self._fresh = session, folder, live, fresh
        self._page: ServerConnection | None = None
        self._layout: dict[str, Any] = {}  # of the page
        self._last: jobs.Answer | None = None
        self._meshes: dict[int, bytes] = {}
        self._sent: set[int] = set()  # meshes that the page has
        self._newest = Asked(0, session.state)
        self._waiting: Asked | None = self._newest
        self._steps = ""  # what the live process is in the middle of: "touch" or "exact"
        self._anchored: tuple[str, State] | None = None
        self._converging: Asked | None = None
        self._jobs: list[tuple[str, Callable[[], Awaitable[None]]]] = []
        self._quick: list[Callable[[], Awaitable[None]]] = []  # jobs of the live process
        self._doing = ""  # by the fresh process
        self._lightest: dict[str, Any] | None = None
        self._crashes = 0
        self._live_work, self._fresh_work = asyncio.Event(), asyncio.Event()

    async def run(self) -> None:
        """Compute until this is cancelled."""
        try:
            async with asyncio.TaskGroup() as group:
                group.create_task(self._drive(self._live_step, self._live_work))
                group.create_task(self._drive(self._fresh_step, self._fresh_work))
        finally:
            self._live.stop()
            self._fresh.stop()

    async def meet(self, page: ServerConnection) -> None:
        """Talk to a page until it leaves; one that is open already is closed."""
        before, self._page, self._sent = self._page, page, set()
        if before is not None:
            await before.close(_REPLACED, "opened in another tab")
        with suppress(ConnectionClosed):
            await self._tell("hello", serial=self._newest.serial, layout=self._layout, doing=self._doing)
            await self._tell_session()
            if self._last is not None:
                await self._show(self._last)
            async for message in page:
                await self._hear(message)
                await asyncio.sleep(0)  # what computes has its turn also while requests pour in
        if self._page is page:
            self._page = None

    # What the page says.

    async def _hear(self, message: str | bytes) -> None:
        try:
            told = json.loads(message)
            await getattr(self, f"_on_{told.pop('do')}")(**told)
        except (ValueError, LookupError, TypeError, AttributeError) as error:
            await self._note(f"The page asked for what cannot be: {error}")

    async def _on_ask(
        self, serial: int, state: State, *, rests: bool, touched: str = "", field: str = "von_mises"
    ) -> None:
        """A design, while it is changed or once it rests."""
        asked = Asked(int(serial), _checked(state), bool(rests), str(touched), str(field))
        if rests:
            self._session.change("commit", state=asked.state)
            await self._tell_session()
        self._ask(asked)

    async def _on_move(self, serial: int, by: int) -> None:
        """Undo or redo."""
        self._session.change("move", by=int(by))
        await self._go(serial)

    async def _on_go(self, serial: int, name: str) -> None:
        """Return to a variant."""
        self._session.change("commit", state=self._session.variants[name]["state"])
        await self._go(serial)

    async def _go(self, serial: int) -> None:
        await self._tell_session(serial=serial)
        self._ask(Asked(int(serial), self._session.state))

    async def _on_keep(self, name: str) -> None:
        """Keep the design at hand as a variant."""
        await self._keep(name, self._session.state)

    async def _keep(self, name: str, state: State) -> None:
        name = " ".join(str(name).split())[:_LONGEST_NAME] or f"variant {len(self._session.variants) + 1}"
        self._session.change("keep", name=name, state=state, answer=self._known(state))
        await self._tell_session()

    async def _on_remove(self, name: str) -> None:
        self._session.change("remove", name=name)
        await self._tell_session()

    async def _on_export(self, what: str, name: str = "") -> None:
        """Write a study, a solid, a report or the table of variants beside the session."""
        if what not in jobs.EXPORTS:
            raise ValueError(what)
        now = {"state": self._session.state, "answer": self._known(self._session.state)}
        variants = {"now": now, **self._session.variants}
        state = variants[name or "now"]["state"]

        async def export() -> None:
            worker = self._live if what in jobs.QUICK else self._fresh
            written = await worker.run(jobs.export, what, state, variants, str(self._folder), name)
            await self._tell("written", **written)

        if what in jobs.QUICK:
            self._quick.append(export)
            self._live_work.set()
        else:
            self._queue(what, export)

    async def _on_lighten(self) -> None:
        """Look for the lightest rod from the design at hand, which becomes a variant."""
        state, self._lightest = self._session.state, None

        def tried(line: str) -> None:
            design = json.loads(line)
            if (
                design["margin"] >= 0
                and design["mass_kg"] < (self._lightest or design | {"mass_kg": 1e9})["mass_kg"]
            ):
                self._lightest = design
            self._background(self._tell("tried", design=design))

        async def lighten() -> None:
            try:
                found = await self._fresh.run(jobs.lighten, state, listener=tried)
                self._lightest = found if found["holds"] else None
            finally:
                text = "No rod was found that holds."
                if self._lightest is not None:
                    await self._keep("lightest", self._lightest["state"])
                    grams = 1000 * self._lightest["mass_kg"]
                    text = f"The lightest rod that holds weighs {grams:.4g} g: see the variant “lightest”."
                await self._note(text, bad=False)

        self._queue("lighten", lighten)

    async def _on_stop(self) -> None:
        """End what the fresh process does."""
        self._jobs, self._converging = [], None
        self._doing = ""
        self._fresh.stop()

    # What the page is told.

    async def _tell(self, kind: str, **what: Any) -> None:
        if self._page is not None:
            with suppress(ConnectionClosed):
                await self._page.send(json.dumps({"kind": kind, **what}))

    async def _note(self, text: str, *, bad: bool = True) -> None:
        await self._tell("note", text=text, bad=bad)

    async def _tell_session(self, **more: Any) -> None:
        await self._tell("session", **self._session.told(), **more)

    async def _show(self, answer: jobs.Answer) -> None:
        """Send a frame, and before it its mesh where the page does not have it."""
        if self._page is None:
            return
        mesh = answer.header.get("mesh")
        with suppress(ConnectionClosed):
            if mesh is not None and mesh not in self._sent:
                await self._page.send(_packed({"kind": "mesh", "mesh": mesh}, self._meshes[mesh]))
                self._sent.add(mesh)
            await self._page.send(_packed(answer.header, answer.numbers))

    async def _answered(self, answer: jobs.Answer) -> None:
        """Send a frame of a worker, and let variants of its design have its figures."""
        if "mesh" in answer.header:
            self._meshes.pop(answer.header["mesh"], None)
            self._meshes[answer.header["mesh"]] = answer.triangles
            for old in list(self._meshes)[:-_MESHES]:
                del self._meshes[old]
                self._sent.discard(old)
        self._last = answer._replace(triangles=b"")
        await self._show(self._last)
        known = self._known(answer.header["state"])
        if known is not None and self._session.answered(answer.header["state"], known):
            await self._tell_session()

    def _known(self, state: State) -> dict[str, Any] | None:
        """Return label and figures of a design, if they are those of the last frame and not interpolated."""
        header = {} if self._last is None else self._last.header
        if header.get("state") != state or header["figures"] is None or header["label"] not in KNOWN:
            return None
        return {key: header[key] for key in ("label", "pins", "figures")}

    def _background(self, coroutine: Any) -> None:
        task = asyncio.ensure_future(coroutine)
        self._tasks = {task, *(other for other in getattr(self, "_tasks", ()) if not other.done())}

    # The processes.

    @staticmethod
    async def _drive(step: Callable[[], Awaitable[bool]], work: asyncio.Event) -> None:
        """Take step after step; wait where there is nothing to do."""
        while True:
            work.clear()
            if not await step():
                await work.wait()

    def _ask(self, asked: Asked) -> None:
        """Let a request replace those before it."""
        self._newest = self._waiting = asked
        self._converging, self._crashes = None, 0
        if self._doing == _CONVERGING:
            self._fresh.stop()
        self._live_work.set()

    async def _live_step(self) -> bool:
        """Answer the newest request, or go on with what takes longer."""
        asked, self._waiting = self._waiting, None
        try:
            if not self._layout:
                self._layout = await self._live.run(jobs.describe)
                await self._tell("hello", serial=self._newest.serial, layout=self._layout)
                await self._tell_session()
            if asked is not None:
                await self._answer(asked)
            elif self._quick:
                await self._quick.pop(0)()
            elif self._steps:
                await self._go_on(self._newest)
            else:
                return False
        except (CrashError, MemoryError) as error:
            self._steps, self._anchored, self._crashes = "", None, self._crashes + 1
            again = self._crashes < _MOST_CRASHES
            self._waiting = self._waiting or (self._newest if again else None)
            more = "It is started again." if again else "Change the design to start it again."
            await self._note(f"The process that answers has ended: {error}. {more}")
        except Exception as error:  # noqa: BLE001 - what is wrong with a design is said on the page
            self._steps = ""
            await self._refuse(asked or self._newest, error)
        return True

    async def _answer(self, asked: Asked) -> None:
        """Give the answer that is there at once, and begin what takes longer."""
        live, state = self._live, asked.state
        if asked.touched and asked.touched != (self._anchored and self._anchored[0]):
            self._anchored, self._steps = (asked.touched, state), "touch"
            await self._tell_ranges(asked)
            await live.run(jobs.begin, "touch", state, asked.touched)
        if asked.rests:
            self._anchored, self._steps = None, "exact"
            await live.run(jobs.begin, "exact", state, asked.field)
        else:
            await self._answered(await live.run(jobs.frame, asked.serial, state, asked.field))

    async def _go_on(self, asked: Asked) -> None:
        """Solve one more anchor, or the next exact answer."""
        found = await self._live.run(jobs.step, asked.serial, asked.state)
        if isinstance(found, jobs.Answer):
            await self._answered(found)
            await self._tell_ranges(asked)
        elif found is None and self._steps == "exact":
            self._steps, self._converging = "", asked
            self._fresh_work.set()
        elif found is None:
            self._steps = ""
        else:
            await self._tell("anchors", share=found)
            if self._waiting is None and not asked.rests:
                self._waiting = asked

    async def _tell_ranges(self, asked: Asked) -> None:
        await self._tell("ranges", serial=asked.serial, ranges=await self._live.run(jobs.ranges, asked.state))

    def _queue(self, what: str, job: Callable[[], Awaitable[None]]) -> None:
        self._jobs.append((what, job))
        if self._doing == _CONVERGING:
            self._fresh.stop()
        self._fresh_work.set()

    async def _fresh_step(self) -> bool:
        """Do what the page ordered, or else solve the design that rests on a mesh of its own."""
        asked = self._converging
        if self._jobs:
            self._doing, job = self._jobs.pop(0)
        elif asked is not None:
            self._doing, job, self._converging = _CONVERGING, partial(self._converge, asked), None
        else:
            return False
        doing = self._doing
        await self._tell("doing", what=doing)
        try:
            await job()
        except (CrashError, MemoryError) as error:
            interrupted = doing == _CONVERGING and (asked is not self._newest or self._jobs)
            if self._doing and not interrupted:
                await self._note(f"The process that meshes has ended: {error}. The next job starts another.")
            elif self._jobs and asked is self._newest:
                self._converging = asked
        except Exception as error:  # noqa: BLE001 - what is wrong with a design is said on the page
            await self._refuse(self._newest, error)
        self._doing = ""
        await self._tell("doing", what="")
        return True

    async def _converge(self, asked: Asked) -> None:
        answer = await self._fresh.run(jobs.converge, asked.serial, asked.state)
        if asked is self._newest:
            await self._answered(answer)

    async def _refuse(self, asked: Asked, error: Exception) -> None:
        text = " ".join(str(error).split()) or type(error).__name__
        await self._tell("refused", serial=asked.serial, text=text)


def _checked(state: Any) -> State:
    """Return a design that the page sent, if it is one: numbers by name, and numbers or names by name."""
    design, operation = dict(state["design"]), dict(state["operation"])
    for value in (*design.values(), *(each for each in operation.values() if not isinstance(each, str))):
        if isinstance(value, bool) or not isinstance(value, int | float) or not isfinite(value):
            raise ValueError(f"{value!r} is not a number")
    return {"design": design, "operation": operation}


def _packed(header: Mapping[str, Any], numbers: bytes) -> bytes:
    """One message: the length of the header, the header, padded to whole words, and the numbers."""
    text = json.dumps(header).encode()
    text += b" " * (-len(text) % 4)
    return len(text).to_bytes(4, "little") + text + numbers


async def serve_studio(
    studio: Studio, page: str, policy: str, port: int, opened: Callable[[str], None]
) -> None:
    """Serve the page on this machine until this is cancelled; `opened` is told its address.

    Raises
    ------
    OSError
        The port is taken.
    """
    logging.getLogger("websockets").addHandler(logging.NullHandler())
    access = Access(port, page, policy)
    async with serve(
        studio.meet,
        "127.0.0.1",
        port,
        process_request=access,
        compression=None,
        max_size=_LONGEST_MESSAGE,
        server_header=None,
    ) as server:
        access.port = next(iter(server.sockets)).getsockname()[1]
        opened(access.address)
        await studio.run()
