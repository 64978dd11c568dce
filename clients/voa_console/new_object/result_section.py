"""Section of the result: what to know about the scenario, its files, the page that shows it, and a session."""

from nicegui import ui

from voa_client import SessionRequest, VoaClientError
from voa_console.context import Console
from voa_console.new_object.bench import Bench
from voa_console.new_object.fields import heading, notice
from voa_console.new_object.messages import Made
from voa_console.new_object.wording import counted
from voa_console.sentences import sentence_of


class ResultSection:
    """Section of the result.

    Args:
        console: with the client that opens the session.
        bench: of the new object.
    """

    def __init__(self, console: Console, bench: Bench) -> None:
        self._console, self._bench = console, bench
        self._shown: Made | None = None
        self._card = ui.card().classes("w-full gap-3")
        self.update()

    def update(self) -> None:
        """Show the scenario, once it is made."""
        job = self._bench.job
        made = None if job is None else job.made
        self._card.set_visibility(made is not None)
        if made is not None and made is not self._shown:
            self._shown = made
            self._card.clear()
            with self._card:
                self._draw(made)

    def _draw(self, made: Made) -> None:
        heading(f"The scenario {made.name} is made")
        ui.label(
            f"{counted(made.poses, 'pose')}, {counted(len(made.grasps), 'grasp')}, {counted(made.places, 'place')}, in "
            f"{made.folder}."
        )
        ranking = made.ranking
        best = ranking.best_grasp_before or "none"
        ui.label(f"Best grasp without a look: {best}, expected score {ranking.expected_score_before:.2f}.")
        first = ranking.ranking[0] if ranking.ranking else None
        if first is not None:
            ui.label(f"Most worth: a look from {first.sensor}, which adds {first.voa:+.2f}.")
        for text in made.warnings:
            notice(text)
        with ui.row().classes("items-center gap-3"):
            ui.button("Open a session", on_click=self._open)
            files = f"/new/files/{self._bench.id}"
            ui.link("Download as ZIP", f"{files}/scenario.zip").props("download").classes("text-base")
            ui.link("Open the page in a tab of its own", f"{files}/look.html", new_tab=True).classes("text-base")
        with ui.expansion("Decided, merged or guessed").classes("w-full"):
            for note in made.notes:
                ui.label(note).classes("text-sm")
        ui.label("Is it right? Go through the drawings before a robot uses the scenario.").classes("text-base")
        frame = ui.element("iframe").props('sandbox=""').classes("w-full rounded bg-white")
        frame.props["src"], frame.props["title"] = f"{files}/look.html", f"Is {made.name} right?"
        frame.style("height: 70vh; border: 1px solid #8888;")

    async def _open(self) -> None:
        made = self._shown
        if made is None:
            return
        try:
            session = await self._console.client.create_session(SessionRequest(scenario=made.scenario))
        except VoaClientError as error:
            ui.notify(sentence_of(error), type="negative", multi_line=True)
            return
        ui.navigate.to(f"/sessions/{session.id}")
