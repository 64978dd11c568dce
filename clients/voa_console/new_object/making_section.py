"""Section of the making: the folder, the button, the progress, and the button that ends it."""

import time
from collections.abc import Callable
from pathlib import Path

from nicegui import ui

from voa_console.new_object.bench import Bench
from voa_console.new_object.draft import command_of, problems_of
from voa_console.new_object.fields import heading, notice
from voa_console.new_object.folders import UnusableTarget, has_scenario, target_folder
from voa_console.new_object.job import Job
from voa_console.new_object.wording import duration
from voa_console.new_object.workshop import Workshop


class MakingSection:
    """Section of the making.

    Args:
        bench: of the new object.
        workshop: with the other new objects, of which one is made at a time.
        anywhere: True if the person may name any folder of this machine.
    """

    def __init__(self, bench: Bench, workshop: Workshop, *, anywhere: bool) -> None:
        self._bench, self._workshop, self._anywhere = bench, workshop, anywhere
        self._problems: tuple[str, ...] = ()
        with ui.card().classes("w-full gap-3"):
            heading("6. Make the scenario")
            self._target = ui.input("Folder on the machine of this console", value=bench.target, on_change=self._named)
            self._target.props("dense outlined").props["hint"] = f"from {Path.cwd()}, unless the path is absolute"
            self._target.classes("w-full max-w-xl")
            with ui.expansion("As a command").classes("w-full"):
                ui.label("The same choices at a terminal give the same files:").classes("text-sm")
                self._command = ui.label().classes("font-mono text-sm break-all")
            self._complaints = ui.column().classes("gap-1")
            with ui.row().classes("items-center gap-3"):
                self._make = ui.button("Make the scenario", on_click=self._begin)
                self._cancel = ui.button("Cancel", on_click=self._end, color="negative").props("outline")
            self._progress = ui.column().classes("w-full gap-1")
            with self._progress:
                self._text = ui.label().props('role="status"')
                self._bar = ui.linear_progress(0.0, show_value=False).props('aria-label="Progress" size="14px" rounded')
        with ui.dialog() as self._dialog, ui.card().classes("gap-3 max-w-md").props('role="dialog"'):
            self._question = ui.label()
            with ui.row().classes("w-full justify-end"):
                ui.button("Keep it", on_click=self._dialog.close).props("flat")
                ui.button("Write over it", on_click=self._overwrite, color="negative")
        self.update()

    def update(self) -> None:
        """Show the draft, and the job if there is one."""
        bench = self._bench
        draft, job = bench.draft, bench.job
        if draft is None:
            return
        if self._target.value != bench.target:
            self._target.set_value(bench.target)
        plan = bench.previews.plan
        problems = tuple(problems_of(draft))
        if not problems and bench.previews.is_current("plan", draft):
            self._command.set_text(command_of(draft, bench.target))
        blocked = plan is None or plan.problem is not None or bool(bench.previews.problems)
        self._make.set_enabled(not (problems or blocked or bench.is_making))
        self._cancel.set_visibility(bench.is_making)
        self._progress.set_visibility(job is not None)
        complaints = problems
        if job is not None:
            self._show(job)
            complaints += (job.sentence,) if job.state == "failed" else ()
        if complaints != self._problems:
            self._problems = complaints
            self._complaints.clear()
            with self._complaints:
                for text in complaints:
                    notice(text, grave=True)

    def _show(self, job: Job) -> None:
        """Show the step of the job and its progress, or how it ended."""
        share = job.share
        if job.state == "running":
            count = "" if job.total is None else f", {job.done} of {job.total}"
            self._text.set_text(f"{job.text.capitalize()}{count} ({duration(job.seconds(time.monotonic))})")
        else:
            texts = {"done": "Done.", "failed": "Not made.", "cancelled": "Cancelled; finished attempts are kept."}
            self._text.set_text(texts[job.state])
        self._bar.props("indeterminate" if job.state == "running" and share is None else "indeterminate=false")
        self._bar.set_value(1.0 if job.state == "done" else share or 0.0)

    def _named(self) -> None:
        self._bench.target = self._target.value or ""

    def _begin(self) -> None:
        self._checked(self._start_or_question)

    def _start_or_question(self, folder: Path) -> None:
        if has_scenario(folder):
            self._question.set_text(f"{folder} has a scenario already. Write over it?")
            self._dialog.open()
            return
        self._bench.make(folder, force=False)

    def _overwrite(self) -> None:
        self._dialog.close()
        self._checked(lambda folder: self._bench.make(folder, force=True))

    def _checked(self, use: Callable[[Path], None]) -> None:
        """Use the folder that the person named, if it can be used and no other scenario is being made."""
        other = self._workshop.making()
        if other is not None:
            name = other.name if other.key == self._bench.key else "An object of somebody else"
            ui.notify(f"{name} is being made: wait for its end, or cancel it.", type="warning")
            return
        try:
            folder = target_folder(self._bench.target, Path.cwd(), anywhere=self._anywhere)
        except UnusableTarget as error:
            ui.notify(str(error), type="negative", multi_line=True)
            return
        use(folder)

    async def _end(self) -> None:
        await self._bench.cancel()
