"""Section of the rests: a turning picture of each with a box to tick, and the number of yaws."""

from nicegui import ui

from voa_console.new_object.bench import Bench
from voa_console.new_object.fields import NumberField, heading, notice
from voa_console.new_object.wording import counted, sentence
from voa_setup.previews.messages import RestPreview, RestsPreview


class RestsSection:
    """Section of the rests.

    Args:
        bench: of the new object.
    """

    def __init__(self, bench: Bench) -> None:
        self._bench = bench
        self._drawn: RestsPreview | None = None
        self._boxes: dict[str, ui.checkbox] = {}
        self._is_showing = False
        with ui.card().classes("w-full gap-3"):
            heading("2. How it rests")
            ui.label("Tick the ways in which the object may lie on your table; a picture stops under the mouse.")
            self._rests = ui.row().classes("w-full gap-3")
            self._notes = ui.column().classes("gap-1")
            self._merged = ui.label().classes("text-sm opacity-70")
            with ui.row().classes("items-center gap-4"):
                self._yaws = NumberField(
                    "Yaws of each rest",
                    lambda: None if bench.draft is None else bench.draft.yaws,
                    self._typed,
                    low=1,
                    high=360,
                )
                self._count = ui.label().classes("text-base").props('aria-live="polite"')
        self.update()

    def update(self) -> None:
        """Show the draft and its poses."""
        bench, draft = self._bench, self._bench.draft
        if draft is None or bench.previews.rests is None:
            return
        if self._drawn is not bench.previews.rests:
            self._drawn = bench.previews.rests
            self._draw(bench.previews.rests)
        self._is_showing = True  # a box that is set here is no choice of a person
        for rest in bench.previews.rests.rests:
            self._boxes[rest.name].set_value(rest.likely if draft.rests is None else rest.name in draft.rests)
        self._is_showing = False
        self._yaws.update()
        plan = bench.previews.plan
        if plan is None or not bench.previews.is_current("plan", draft):
            self._count.set_text("counting the poses ...")
            return
        self._merged.set_text(" ".join(map(sentence, plan.notes)))
        poses = sum(len(rest.poses) for rest in plan.rests)
        kept = counted(len(plan.rests), "rest")
        self._count.set_text(f"{counted(poses, 'pose')} from {kept}; those that look the same count once.")

    def _draw(self, preview: RestsPreview) -> None:
        self._rests.clear()
        self._boxes.clear()
        with self._rests:
            for rest in preview.rests:
                self._draw_rest(rest)
        self._notes.clear()
        with self._notes:
            for note in preview.notes:
                notice(sentence(note))

    def _draw_rest(self, rest: RestPreview) -> None:
        with ui.column().classes("items-center gap-0"):
            if rest.picture is not None:
                source = f"/new/files/{self._bench.id}/{rest.picture}?{self._bench.revision}"
                picture = ui.element("div").classes("voa-turn").style(f"background-image: url('{source}')")
                picture.props("role=img").props["aria-label"] = f"{rest.name}, turning on the table"
            share = f"{rest.probability:.0%}" if rest.probability >= 0.01 else "below 1%"
            self._boxes[rest.name] = ui.checkbox(
                f"{rest.name}, {share}", value=rest.likely, on_change=self._ticked
            ).props("dense")
            if rest.alike > 1:
                ui.label(f"stands for {rest.alike} that look the same").classes("text-xs opacity-70")

    def _ticked(self) -> None:
        preview, draft = self._bench.previews.rests, self._bench.draft
        if self._is_showing or preview is None or draft is None:
            return
        kept = tuple(rest.name for rest in preview.rests if self._boxes[rest.name].value)
        likely = tuple(rest.name for rest in preview.rests if rest.likely)
        self._bench.change(rests=None if kept == likely else kept)

    def _typed(self, value: float | None) -> None:
        if value is not None:
            self._bench.change(yaws=int(value))
