"""The server's side of one page, whose requests two worker processes answer.

The page numbers its requests. An answer carries that number and its design in one message with its picture; a
request that is not answered yet is dropped when another comes.
"""

import asyncio
import json
from collections.abc import Awaitable, Callable, Mapping
from contextlib import suppress
from dataclasses import dataclass
from functools import partial
from math import isfinite
from pathlib import Path
from typing import Any

from websockets.asyncio.server import ServerConnection
from websockets.exceptions import ConnectionClosed

from fea.apps.studio import jobs
from fea.apps.studio.figures import LARGEST_OF_CASES
from fea.apps.studio.jobs import FrameMessage, Worker
from fea.apps.studio.session import KNOWN, Session, State
from fea.machine.isolated import CrashError
from fea.output.json_file import JsonObject

# Crashes over one request after which it is given up.
_MOST_CRASHES = 2
_LONGEST_NAME = 60
_MESHES = 4  # that are kept for a page that is loaded again
_REPLACED = 4000  # code with which a socket is closed (of the range for applications)
_TOUCH, _EXACT, _CONVERGE = "touch", "exact", "converge"
Job = Callable[[], Awaitable[None]]


@dataclass(frozen=True)
class DesignRequest:
    """A design that the page asks about."""

    serial: int
    state: State
    rests: bool = True  #: whether no slider is being moved: exact answers are wanted, too
    touched: str = ""  #: the dimension that is being changed
    field: str = LARGEST_OF_CASES  #: what the picture shows


class Studio:
    """One page, its session, and the two processes that compute for it."""

    def __init__(self, session: Session, folder: Path, live: Worker, fresh: Worker) -> None:
        self._session, self._folder, self._live, self._fresh = session, folder, live, fresh
        self._page: ServerConnection | None = None
        self._layout: JsonObject = {}  # of the page
        self._last: FrameMessage | None = None
        self._meshes: dict[int, bytes] = {}
        self._sent: set[int] = set()  # meshes that the page has
        self._top = 0.0  # end of the legend, which is kept while peaks are similar
        self._newest = DesignRequest(0, session.state)
        self._waiting: DesignRequest | None = self._newest
        self._steps = ""  # the job of several steps that the live process has begun
        self._sampled: DesignRequest | None = None  # where it samples designs
        self._converging: DesignRequest | None = None
        self._quick: list[Job] = []  # for the live process
        self._jobs: list[tuple[str, Job]] = []  # for the fresh one
        self._doing = ""  # the fresh one's present job
        self._sending: set[asyncio.Task[None]] = set()
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
        """Serve a page until it leaves; one that is open already is closed."""
        before, self._page, self._sent = self._page, page, set()
        if before is not None:
            await before.close(_REPLACED, "opened in another tab")
        with suppress(ConnectionClosed):
            await self._greet()
            if not self._layout:  # it may have been refused, which is reported again
                self._live_work.set()
            if self._last is not None:
                await self._show(self._last)
            async for message in page:
                await self._receive(message)
                await asyncio.sleep(0)  # what computes has its turn also while requests pour in
        if self._page is page:
            self._page = None

    # Requests of the page.

    async def _receive(self, message: str | bytes) -> None:
        try:
            request = json.loads(message)
            await getattr(self, f"_on_{request.pop('do')}")(**request)
        except (ValueError, LookupError, TypeError, AttributeError) as error:
            await self._note(f"The page sent an invalid request: {error}")
        except OSError as error:
            await self._note(f"The session could not be saved: {error.strerror}")

    async def _on_ask(
        self, serial: int, state: State, *, rests: bool, touched: str = "", field: str = LARGEST_OF_CASES
    ) -> None:
        numbers = (value for value in state["operation"].values() if not isinstance(value, str))
        if not all(map(isfinite, (*state["design"].values(), *numbers))):
            raise ValueError(state)
        if rests:
            await self._change("commit", state=state)
        self._ask(DesignRequest(int(serial), state, bool(rests), str(touched), str(field)))

    async def _on_move(self, serial: int, by: int) -> None:
        await self._change("move", serial, by=int(by))

    async def _on_go(self, serial: int, name: str) -> None:
        await self._change("commit", serial, state=self._session.variants[name]["state"])

    async def _on_keep(self, name: str, state: State | None = None) -> None:
        name = " ".join(str(name).split())[:_LONGEST_NAME] or f"variant {len(self._session.variants) + 1}"
        state = state or self._session.state
        await self._change("keep", name=name, state=state, answer=self._kept_answer(state))

    async def _on_remove(self, name: str) -> None:
        await self._change("remove", name=name)

    async def _change(self, kind: str, serial: int | None = None, **what: Any) -> None:
        """Change the session; with a serial, the present design is another one, which is asked about."""
        self._session.change(kind, **what)
        await self._send("session", **self._session.described(), serial=serial)
        if serial is not None:
            self._ask(DesignRequest(int(serial), self._session.state))

    async def _on_export(self, what: str, name: str = "") -> None:
        now = {"state": self._session.state, "answer": self._kept_answer(self._session.state)}
        variants = {"now": now, **self._session.variants}
        order = (jobs.export, what, variants[name or "now"]["state"], variants, str(self._folder), name)

        async def export(worker: Worker) -> None:
            await self._send("written", **await worker.run(*order))

        if what in jobs.QUICK:
            self._quick.append(partial(export, self._live))
            self._live_work.set()
        elif what in jobs.SLOW:
            self._queue(what, partial(export, self._fresh))
        else:
            raise ValueError(what)

    async def _on_lighten(self) -> None:
        state, best = self._session.state, list[JsonObject]()

        def tried(line: str) -> None:
            design = json.loads(line)
            if design["margin"] >= 0 and (not best or design["mass_kg"] < best[-1]["mass_kg"]):
                best.append(design)
            task = asyncio.ensure_future(self._send("tried", design=design))
            self._sending.add(task)
            task.add_done_callback(self._sending.discard)

        async def lighten() -> None:
            text = "The search ended before a rod met the required factors."
            try:
                found = await self._fresh.run(jobs.lighten, state, listener=tried)
                best[:] = [found] if found["margin"] >= 0 else []
                text = f"No rod met the required factors: the best one lacks {-found['margin']:.0%}."
            finally:  # also where it was stopped
                if best:
                    await self._on_keep("lightest", best[-1]["state"])
                    grams = 1000 * best[-1]["mass_kg"]
                    text = f"The lightest rod has {grams:.4g} g: see the variant “lightest”."
                await self._note(text, bad=False)

        self._queue("lighten", lighten)

    async def _on_stop(self) -> None:
        self._jobs, self._doing = [], ""
        self._fresh.stop()

    # Messages to the page.

    async def _send(self, kind: str, **what: Any) -> None:
        if self._page is not None:
            with suppress(ConnectionClosed):
                await self._page.send(json.dumps({"kind": kind, **what}))

    async def _note(self, text: str, *, bad: bool = True) -> None:
        await self._send("note", text=text, bad=bad)

    async def _greet(self) -> None:
        await self._send("hello", serial=self._newest.serial, layout=self._layout, doing=self._doing)
        await self._send("session", **self._session.described())

    async def _show(self, answer: FrameMessage) -> None:
        mesh = answer.header.get("mesh")
        if self._page is None:
            return
        with suppress(ConnectionClosed):
            if mesh is not None and mesh not in self._sent:
                await self._page.send(_packed({"kind": "mesh", "mesh": mesh}, self._meshes[mesh]))
                self._sent.add(mesh)
            await self._page.send(_packed(answer.header, answer.numbers))

    async def _show_new(self, answer: FrameMessage) -> None:
        mesh, state = answer.header.get("mesh"), answer.header["state"]
        if mesh is not None:
            self._top = answer.header["field"]["limits"][-1]
            self._meshes.pop(mesh, None)  # the newest stands last
            self._meshes[mesh] = answer.triangles
            for old in list(self._meshes)[:-_MESHES]:
                del self._meshes[old]
                self._sent.discard(old)
        self._last = answer
        await self._show(answer)
        kept = self._kept_answer(state)
        if kept is not None and self._session.answered(state, kept):
            await self._send("session", **self._session.described())

    def _kept_answer(self, state: State) -> JsonObject | None:
        header = {} if self._last is None else self._last.header
        if header.get("state") != state or header["figures"] is None or header["label"] not in KNOWN:
            return None
        return {key: header[key] for key in ("label", "pins", "one_piece", "figures")}

    async def _refuse(self, request: DesignRequest, error: Exception) -> None:
        text = " ".join(str(error).split()) or type(error).__name__
        await self._send("refused", serial=request.serial, text=text)

    # The processes.

    @staticmethod
    async def _drive(step: Callable[[], Awaitable[bool]], work: asyncio.Event) -> None:
        while True:
            work.clear()
            if not await step():
                await work.wait()

    def _ask(self, request: DesignRequest) -> None:
        self._newest = self._waiting = request
        self._converging, self._crashes = None, 0
        if self._doing == _CONVERGE:
            self._fresh.stop()
        self._live_work.set()

    async def _live_step(self) -> bool:
        request, self._waiting = self._waiting, None
        try:
            if not self._layout:
                self._layout = await self._live.run(jobs.describe)
                await self._greet()
            if request is not None:
                await self._respond(request)
            elif self._quick:
                await self._quick.pop(0)()
            elif self._steps:
                await self._step(self._newest)
            else:
                return False
        except (CrashError, MemoryError) as error:
            self._steps, self._sampled, self._crashes = "", None, self._crashes + 1
            again = self._crashes < _MOST_CRASHES
            self._waiting = self._waiting or (self._newest if again else None)
            more = "It is being restarted." if again else "Change the design to restart it."
            await self._note(f"The process that answers has ended: {error}. {more}")
        except Exception as error:  # noqa: BLE001 - what is wrong with a design is shown on the page
            self._steps = ""
            await self._refuse(request or self._newest, error)
            return bool(self._layout)  # the study itself cannot be solved: until someone asks again
        return True

    async def _respond(self, request: DesignRequest) -> None:
        if request.rests:
            await self._begin(_EXACT, request, request.field)
            return
        if request.touched and (self._sampled is None or self._sampled.touched != request.touched):
            await self._begin(_TOUCH, request, request.touched)
        answer = await self._live.run(jobs.frame, request.serial, request.state, self._top, request.field)
        await self._show_new(answer)
        # Beyond the sampled designs others are sampled, around the present one.
        known = answer.header["figures"] is not None or self._steps
        if request.touched and not known and self._sampled and self._sampled.state != request.state:
            await self._begin(_TOUCH, request, request.touched)

    async def _begin(self, what: str, request: DesignRequest, of: str) -> None:
        self._steps, self._sampled = what, request if what == _TOUCH else None
        await self._live.run(jobs.begin, what, request.state, of)
        await self._send_ranges(request)

    async def _step(self, request: DesignRequest) -> None:
        found = await self._live.run(jobs.step, request.serial, request.state, self._top)
        if isinstance(found, FrameMessage):
            await self._show_new(found)
        elif found is None:
            ended, self._steps = self._steps, ""
            if ended == _EXACT:
                self._converging = request
                self._fresh_work.set()
            await self._send_ranges(request)
        elif self._steps == _TOUCH:
            await self._send("sampling", share=found)
            self._waiting = self._waiting or self._newest

    async def _send_ranges(self, request: DesignRequest) -> None:
        found = await self._live.run(jobs.ranges, request.state)
        await self._send("ranges", serial=request.serial, ranges=found)

    def _queue(self, what: str, job: Job) -> None:
        self._jobs.append((what, job))
        if self._doing == _CONVERGE:
            self._converging = self._newest
            self._fresh.stop()
        self._fresh_work.set()

    async def _fresh_step(self) -> bool:
        request = self._converging
        if self._jobs:
            self._doing, job = self._jobs.pop(0)
        elif request is not None:
            self._doing, job, self._converging = _CONVERGE, partial(self._converge, request), None
        else:
            return False
        doing = self._doing
        await self._send("doing", what=doing)
        try:
            await job()
        except (CrashError, MemoryError) as error:
            ended = doing == _CONVERGE and (request is not self._newest or self._jobs)  # by this server
            if self._doing and not ended:
                await self._note(f"The process that meshes has ended: {error}. The next job starts another.")
        except Exception as error:  # noqa: BLE001 - what is wrong with a design is shown on the page
            await self._refuse(self._newest, error)
        self._doing = ""
        await self._send("doing", what="")
        return True

    async def _converge(self, request: DesignRequest) -> None:
        answer = await self._fresh.run(jobs.converge, request.serial, request.state, self._top)
        if request is self._newest:
            await self._show_new(answer)


def _packed(header: Mapping[str, Any], numbers: bytes) -> bytes:
    """One message: the length of the header, the header, padded to whole words, and the numbers."""
    text = json.dumps(header).encode()
    text += b" " * (-len(text) % 4)
    return len(text).to_bytes(4, "little") + text + numbers
