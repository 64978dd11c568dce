"""Bench: one new object with its draft, its previews and its job, whichever pages show it."""

import asyncio
import logging
import time
from collections.abc import Callable
from contextlib import suppress
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

from voa_console.new_object.draft import Draft, first_draft
from voa_console.new_object.job import Job
from voa_console.new_object.messages import Made, Reply, Task
from voa_console.new_object.previewing import SECONDS, WORDS, Previews
from voa_console.new_object.process import TaskFailed, WorkerProcess
from voa_console.new_object.wording import sentence, without_path

_LOG = "worker.log"
IDLE_S = 600.0
"""Time after which a process that has nothing to do ends, seconds: it may hold some hundred megabytes."""


@dataclass(eq=False)
class Bench:
    """New object on some pages, which show it again whenever `revision` has changed.

    Attributes:
        id: in the address of its page.
        url: address of the service.
        key: that a browser gave, by which its processes call the service; None: the key of the console's own process.
        folder: for the mesh file, pictures and a scenario that is only downloaded.
        draft: choices so far; None: there is no mesh yet.
        previews: what is known about the draft.
        job: the making of the scenario; None: it was not started.
        target: folder that the person named for the scenario.
        busy: words for the preview that is under way; empty: none.
        revision: number of changes.
        used_at: time of the last change, by a clock that never goes back.
        idle_s: time after which the process for previews ends that had nothing to do, seconds; it is started again
            when there is something to do.
    """

    id: str
    url: str
    folder: Path
    draft: Draft | None = None
    previews: Previews = field(default_factory=Previews)
    job: Job | None = None
    target: str = ""
    busy: str = ""
    revision: int = 0
    used_at: float = field(default_factory=time.monotonic)
    key: str | None = field(default=None, repr=False)
    idle_s: float = IDLE_S
    _process: WorkerProcess | None = None
    _idle: asyncio.TimerHandle | None = None
    _previewing: asyncio.Task[None] | None = None
    _making: asyncio.Task[None] | None = None

    @property
    def name(self) -> str:
        """Name of the object, or what to call it before there is a mesh."""
        return "new object" if self.draft is None else self.draft.name

    @property
    def is_making(self) -> bool:
        """True while the scenario is made."""
        return self.job is not None and self.job.state == "running"

    async def take(self, mesh: Path) -> None:
        """Begin with a mesh file that was received; raises TaskFailed with what is wrong with it."""
        await self._stop_previews()
        draft = Draft(mesh=str(mesh))
        self.busy = WORDS["measure"]
        self._changed()
        try:
            result = await self._preview(Task(step="measure", draft=draft, folder=str(self.folder)))
        except TaskFailed as error:
            raise TaskFailed(sentence(without_path(str(error), draft))) from error
        finally:
            self.busy = ""
            self._changed()
        self.previews = Previews()
        self.previews.keep("measure", draft, result)
        assert self.previews.measure is not None  # noqa: S101 - just kept
        self.draft = first_draft(mesh, self.previews.measure)
        self.target = self.target or f"build/{self.draft.name}"
        self._changed()

    def change(self, **choices: Any) -> None:
        """Change choices of the draft, and compute again what depends on them."""
        if self.draft is None:
            return
        changed = replace(self.draft, **choices)
        if changed == self.draft:
            return
        if (changed.scale, changed.up) != (self.draft.scale, self.draft.up):
            changed = replace(changed, confirmed=False, rests=None)
        self.draft = changed
        self._changed()
        if self._previewing is None or self._previewing.done():
            self._previewing = asyncio.create_task(self._keep_previews(), name="voa-console-preview")

    def make(self, folder: Path, *, force: bool, clock: Callable[[], float] = time.monotonic) -> None:
        """Start to make the scenario in a folder.

        Args:
            folder: for the files.
            force: True to write over a scenario that is there.
            clock: of the job.
        """
        if self.draft is None or self.is_making:
            return
        self.job = Job(self.draft, str(folder), clock())
        self._changed()
        task = Task(step="make", draft=self.draft, folder=str(folder), force=force)
        self._making = asyncio.create_task(self._make(self.job, task), name="voa-console-make")

    async def cancel(self) -> None:
        """Kill the process that makes the scenario; attempts that are finished stay in its folder."""
        if self._making is not None:
            self._making.cancel()
            with suppress(asyncio.CancelledError):
                await self._making

    async def close(self) -> None:
        """Kill all processes of this bench."""
        await self.cancel()
        await self._stop_previews()
        self._end_process()

    async def _make(self, job: Job, task: Task) -> None:
        def report(reply: Reply) -> None:
            job.receive(reply)
            self._changed()

        try:
            process = await self._start()
            try:
                job.made = Made.model_validate_json(await process.do(task, None, report))
            finally:
                process.kill()
            job.state = "done"
        except TaskFailed as error:
            job.state, job.sentence = "failed", sentence(without_path(str(error), job.draft))
        except asyncio.CancelledError:
            job.state = "cancelled"
            raise
        except Exception:  # a job must not stay "running" whatever went wrong, or no scenario could be made any more
            logging.getLogger(__name__).exception("a scenario was not made")
            job.state, job.sentence = "failed", "The scenario was not made, by a defect of the console; see its log."
        finally:
            self._changed()

    async def _keep_previews(self) -> None:
        """Compute previews, until all belong to the draft as it is now."""
        while self.draft is not None and (step := self.previews.next_step(self.draft)) is not None:
            draft, self.busy = self.draft, WORDS[step]
            self._changed()
            height_m = self.previews.height_of(draft) or 0.0
            try:
                result = await self._preview(Task(step=step, draft=draft, folder=str(self.folder), height_m=height_m))
                self.previews.keep(step, draft, result)
            except TaskFailed as error:
                self.previews.fail(step, draft, sentence(without_path(str(error), draft)))
            finally:
                self.busy = ""
                self._changed()

    async def _preview(self, task: Task) -> str:
        """Do a preview in the process of this bench, which is started again where it has ended; raises TaskFailed."""
        self._stay()
        if self._process is None or not self._process.is_running:
            self._process = await self._start()
        try:
            return await self._process.do(task, SECONDS[task.step], lambda _: None)
        finally:
            self._stay()
            self._idle = asyncio.get_running_loop().call_later(self.idle_s, self._end_process)

    async def _start(self) -> WorkerProcess:
        return await WorkerProcess.start(self.url, self.folder / _LOG, self.key)

    def _stay(self) -> None:
        """Let the process not end for being idle."""
        if self._idle is not None:
            self._idle.cancel()
            self._idle = None

    def _end_process(self) -> None:
        """End the process for previews."""
        self._stay()
        if self._process is not None:
            self._process.kill()
            self._process = None

    async def _stop_previews(self) -> None:
        if self._previewing is not None:
            self._previewing.cancel()
            with suppress(asyncio.CancelledError):
                await self._previewing

    def _changed(self) -> None:
        self.revision += 1
        self.used_at = time.monotonic()
