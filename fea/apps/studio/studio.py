"""What one page asks, and what two processes answer to it.

The page numbers what it asks. An answer carries that number and the design that it is of, in one message
with its picture; a request that is not answered yet is dropped when another comes.
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
from fea.apps.studio.jobs import Worker
from fea.apps.studio.session import KNOWN, Session, State
from fea.machine.isolated import CrashError
from fea.output.json_file import JsonObject

# Times that a process may end over one request before it is given up.
_MOST_CRASHES = 2
_LONGEST_NAME = 60
_MESHES = 4  # that are kept for a page that is loaded again
_REPLACED = 4000  # why a socket is closed (of the range for applications)
_TOUCH, _EXACT, _CROSS, _CONVERGE = "touch", "exact", "cross", "converge"
Job = Callable[[], Awaitable[None]]


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
        self._layout: JsonObject = {}  # of the page
        self._last: jobs.Answer | None = None
        self._meshes: dict[int, bytes] = {}
        self._sent: set[int] = set()  # meshes that the page has
        self._top = 0.0  # end of the legend, which is kept while peaks are like before
        self._newest = Asked(0, session.state)
        self._waiting: Asked | None = self._newest
        self._steps = ""  # what the live process is in the middle of
        self._anchored: Asked | None = None  # where its anchors are
        self._converging: Asked | None = None
        self._quick: list[Job] = []  # for the live process
        self._jobs: list[tuple[str, Job]] = []  # for the fresh one
        self._doing = ""  # by the fresh one
        self._telling: set[asyncio.Task[None]] = set()
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
            await self._greet()
            if not self._layout:  # it may have been refused, which is said again
                self._live_work.set()
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
            await self._note(f"The page sent an invalid request: {error}")
        except OSError as error:
            await self._note(f"The session could not be saved: {error.strerror}")

    async def _on_ask(
        self, serial: int, state: State, *, rests: bool, touched: str = "", field: str = "von_mises"
    ) -> None:
        numbers = (value for value in state["operation"].values() if not isinstance(value, str))
        if not all(map(isfinite, (*state["design"].values(), *numbers))):
            raise ValueError(state)
        if rests:
            await self._change("commit", state=state)
        self._ask(Asked(int(serial), state, bool(rests), str(touched), str(field)))

    async def _on_move(self, serial: int, by: int) -> None:
        await self._change("move", serial, by=int(by))

    async def _on_go(self, serial: int, name: str) -> None:
        await self._change("commit", serial, state=self._session.variants[name]["state"])

    async def _on_keep(self, name: str, state: State | None = None) -> None:
        name = " ".join(str(name).split())[:_LONGEST_NAME] or f"variant {len(self._session.variants) + 1}"
        state = state or self._session.state
        await self._change("keep", name=name, state=state, answer=self._known(state))

    async def _on_remove(self, name: str) -> None:
        await self._change("remove", name=name)

    async def _change(self, kind: str, serial: int | None = None, **what: Any) -> None:
        """Change the session; with a serial, the design at hand is another now, which is asked about."""
        self._session.change(kind, **what)
        await self._tell("session", **self._session.told(), serial=serial)
        if serial is not None:
            self._ask(Asked(int(serial), self._session.state))

    async def _on_export(self, what: str, name: str = "") -> None:
        now = {"state": self._session.state, "answer": self._known(self._session.state)}
        variants = {"now": now, **self._session.variants}
        order = (jobs.export, what, variants[name or "now"]["state"], variants, str(self._folder), name)

        async def export(worker: Worker) -> None:
            await self._tell("written", **await worker.run(*order))

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
            task = asyncio.ensure_future(self._tell("tried", design=design))
            self._telling.add(task)
            task.add_done_callback(self._telling.discard)

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

    # What the page is told.

    async def _tell(self, kind: str, **what: Any) -> None:
        if self._page is not None:
            with suppress(ConnectionClosed):
                await self._page.send(json.dumps({"kind": kind, **what}))

    async def _note(self, text: str, *, bad: bool = True) -> None:
        await self._tell("note", text=text, bad=bad)

    async def _greet(self) -> None:
        await self._tell("hello", serial=self._newest.serial, layout=self._layout, doing=self._doing)
        await self._tell("session", **self._session.told())

    async def _show(self, answer: jobs.Answer) -> None:
        mesh = answer.header.get("mesh")
        if self._page is None:
            return
        with suppress(ConnectionClosed):
            if mesh is not None and mesh not in self._sent:
                await self._page.send(_packed({"kind": "mesh", "mesh": mesh}, self._meshes[mesh]))
                self._sent.add(mesh)
            await self._page.send(_packed(answer.header, answer.numbers))

    async def _answered(self, answer: jobs.Answer) -> None:
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
        known = self._known(state)
        if known is not None and self._session.answered(state, known):
            await self._tell("session", **self._session.told())

    def _known(self, state: State) -> JsonObject | None:
        header = {} if self._last is None else self._last.header
        if header.get("state") != state or header["figures"] is None or header["label"] not in KNOWN:
            return None
        return {key: header[key] for key in ("label", "pins", "one_piece", "figures")}

    async def _refuse(self, asked: Asked, error: Exception) -> None:
        text = " ".join(str(error).split()) or type(error).__name__
        await self._tell("refused", serial=asked.serial, text=text)

    # The processes.

    @staticmethod
    async def _drive(step: Callable[[], Awaitable[bool]], work: asyncio.Event) -> None:
        while True:
            work.clear()
            if not await step():
                await work.wait()

    def _ask(self, asked: Asked) -> None:
        self._newest = self._waiting = asked
        self._converging, self._crashes = None, 0
        if self._doing == _CONVERGE:
            self._fresh.stop()
        self._live_work.set()

    async def _live_step(self) -> bool:
        asked, self._waiting = self._waiting, None
        try:
            if not self._layout:
                self._layout = await self._live.run(jobs.describe)
                await self._greet()
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
            more = "It is being restarted." if again else "Change the design to restart it."
            await self._note(f"The process that answers has ended: {error}. {more}")
        except Exception as error:  # noqa: BLE001 - what is wrong with a design is said on the page
            self._steps = ""
            await self._refuse(asked or self._newest, error)
            return bool(self._layout)  # the study itself cannot be solved: until someone asks again
        return True

    async def _answer(self, asked: Asked) -> None:
        if asked.rests:
            await self._begin(_EXACT, asked, asked.field)
            return
        if asked.touched and (self._anchored is None or self._anchored.touched != asked.touched):
            await self._begin(_TOUCH, asked, asked.touched)
        answer = await self._live.run(jobs.frame, asked.serial, asked.state, self._top, asked.field)
        await self._answered(answer)
        # Beyond the anchors others are solved, from where the hand is now.
        known = answer.header["figures"] is not None or self._steps
        if asked.touched and not known and self._anchored and self._anchored.state != asked.state:
            await self._begin(_TOUCH, asked, asked.touched)

    async def _begin(self, what: str, asked: Asked, of: str = "") -> None:
        self._steps, self._anchored = what, asked if what == _TOUCH else None
        await self._live.run(jobs.begin, what, asked.state, of)
        await self._tell_ranges(asked)

    async def _go_on(self, asked: Asked) -> None:
        found = await self._live.run(jobs.step, asked.serial, asked.state, self._top)
        if isinstance(found, jobs.Answer):
            await self._answered(found)
        elif found is None:
            ended, self._steps = self._steps, ""
            if ended == _EXACT:
                self._converging = asked
                self._fresh_work.set()
                await self._begin(_CROSS, asked)
            else:
                await self._tell_ranges(asked)
        elif self._steps == _TOUCH:
            await self._tell("anchors", share=found)
            self._waiting = self._waiting or self._newest

    async def _tell_ranges(self, asked: Asked) -> None:
        await self._tell("ranges", serial=asked.serial, ranges=await self._live.run(jobs.ranges, asked.state))

    def _queue(self, what: str, job: Job) -> None:
        self._jobs.append((what, job))
        if self._doing == _CONVERGE:
            self._converging = self._newest
            self._fresh.stop()
        self._fresh_work.set()

    async def _fresh_step(self) -> bool:
        asked = self._converging
        if self._jobs:
            self._doing, job = self._jobs.pop(0)
        elif asked is not None:
            self._doing, job, self._converging = _CONVERGE, partial(self._converge, asked), None
        else:
            return False
        doing = self._doing
        await self._tell("doing", what=doing)
        try:
            await job()
        except (CrashError, MemoryError) as error:
            ended = doing == _CONVERGE and (asked is not self._newest or self._jobs)  # by this server
            if self._doing and not ended:
                await self._note(f"The process that meshes has ended: {error}. The next job starts another.")
        except Exception as error:  # noqa: BLE001 - what is wrong with a design is said on the page
            await self._refuse(self._newest, error)
        self._doing = ""
        await self._tell("doing", what="")
        return True

    async def _converge(self, asked: Asked) -> None:
        answer = await self._fresh.run(jobs.converge, asked.serial, asked.state, self._top)
        if asked is self._newest:
            await self._answered(answer)


def _packed(header: Mapping[str, Any], numbers: bytes) -> bytes:
    """One message: the length of the header, the header, padded to whole words, and the numbers."""
    text = json.dumps(header).encode()
    text += b" " * (-len(text) % 4)
    return len(text).to_bytes(4, "little") + text + numbers
