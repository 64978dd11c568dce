"""Section of the scan plane: it slides through the object at each rest, with what it sees, and the warnings."""

from nicegui import ui

from voa_console.new_object.bench import Bench
from voa_console.new_object.fields import NumberField, heading, notice
from voa_console.new_object.pictures import COLOURS, outline_picture, reach_of
from voa_console.new_object.wording import listed, sentence
from voa_setup.previews.messages import Plan, PlaneSight, RestPreview

_MM = 1000.0
_TILE_PX = 150


class PlaneSection:
    """Section of the scan plane.

    Args:
        bench: of the new object.
    """

    def __init__(self, bench: Bench) -> None:
        self._bench = bench
        self._shown: tuple[object, ...] = ()
        self._lines: list[tuple[ui.element, RestPreview]] = []
        with ui.card().classes("w-full gap-3"):
            heading("4. Scan plane")
            ui.label("Slide the plane to where your lidar scans: its height over the object's table.")
            with ui.row().classes("w-full items-center gap-4"):
                self._slider = (
                    ui.slider(min=1, max=100, step=1, on_change=self._slid)
                    .props('label aria-label="Height of the scan plane, slider" debounce=150')
                    .classes("grow min-w-40")
                )
                self._height = NumberField(
                    "Height, mm", self._height_mm, self._typed, low=0.5, high=10_000, hint="over the table"
                )
                self._suggest = ui.button("Suggest", on_click=lambda: bench.change(height_m=None)).props("flat")
            self._sight = ui.label().classes("text-base").props('aria-live="polite"')
            self._tiles = ui.row().classes("w-full gap-4")
            self._warnings = ui.column().classes("w-full gap-1").props('aria-live="polite" aria-label="Warnings"')
        self.update()

    def update(self) -> None:
        """Show the draft, its plane and its warnings."""
        bench, draft, previews = self._bench, self._bench.draft, self._bench.previews
        if draft is None or previews.plan is None:
            return
        self._height.update()
        height_mm = self._height_mm()
        top = max((plane.height_m for plane in previews.plan.planes), default=0.1)
        self._slider.props(f"max={max(10, round(_MM * top) + 10)}")
        if height_mm is not None and self._slider.value != round(height_mm):
            self._slider.set_value(round(height_mm))
        self._suggest.set_visibility(draft.height_m is not None)
        for line, rest in self._lines:
            line.style(f"bottom: {_share(rest, (height_mm or 0.0) / _MM):.1f}%")
        shown = (previews.plan, previews.outlines, previews.problems.get("plan"), bench.previews.rests)
        if shown != self._shown:
            self._shown = shown
            self._draw(previews.plan)

    def _draw(self, plan: Plan) -> None:
        self._sight.set_text(_in_words(plan.chosen, plan))
        self._draw_tiles()
        self._warnings.clear()
        with self._warnings:
            problem = self._bench.previews.problems.get("plan")
            for text in filter(None, (problem, plan.problem)):
                notice(sentence(text), grave=True)
            for text in plan.warnings:
                notice(sentence(text))
            if not (problem or plan.problem or plan.warnings):
                ui.label("The checks give no warning.").classes("text-sm opacity-70")

    def _draw_tiles(self) -> None:
        """Draw the object from the side with the plane, and from above with its outline, for each rest."""
        outlines, rests = self._bench.previews.outlines, self._bench.previews.rests
        self._tiles.clear()
        self._lines = []
        if outlines is None or rests is None:
            return
        named = {rest.name: rest for rest in rests.rests}
        reach = reach_of(outlines.rests)
        tallest = max(_MM * (side[3] - side[2]) for side in (named[each.rest].side_m for each in outlines.rests))
        room = f"{max(40.0, _TILE_PX * tallest / (2.0 * reach)):.0f}px"
        with self._tiles:
            for index, outline in enumerate(outlines.rests):
                with ui.column().classes("gap-1 items-center").style(f"width: {_TILE_PX}px"):
                    self._draw_side(named[outline.rest], reach, room)
                    ui.html(outline_picture(outline, COLOURS[index % len(COLOURS)], reach), sanitize=False).classes(
                        "w-full"
                    )
                    missed = "" if outline.path else ": missed"
                    ui.label(f"{outline.rest}{missed}").classes("text-sm" + (" text-negative" if missed else ""))

    def _draw_side(self, rest: RestPreview, reach_mm: float, room: str) -> None:
        """Draw an object from the side, in the scale of the outline below it, standing on the table."""
        if rest.side is None:
            return
        left, right, bottom, top = rest.side_m
        with ui.element("div").classes("flex items-end justify-center").style(f"height: {room}; width: 100%"):
            frame = ui.element("div").style(
                f"position: relative; width: {100.0 * _MM * (right - left) / (2.0 * reach_mm):.1f}%; "
                f"aspect-ratio: {(right - left) / (top - bottom):.4f}"
            )
        with frame:
            picture = ui.element("img").style("width: 100%; height: 100%; display: block;")
            picture.props["src"] = f"/new/files/{self._bench.id}/{rest.side}?{self._bench.revision}"
            picture.props["alt"] = f"{rest.name} from the side, with the scan plane"
            line = ui.element("div").classes("voa-plane")
            line.style(f"bottom: {_share(rest, (self._height_mm() or 0.0) / _MM):.1f}%")
        self._lines.append((line, rest))

    def _height_mm(self) -> float | None:
        draft = self._bench.draft
        height = None if draft is None else self._bench.previews.height_of(draft)
        return None if height is None else round(_MM * height, 3)

    def _slid(self) -> None:
        if self._slider.value is not None and self._slider.value != round(self._height_mm() or 0.0):
            self._typed(float(self._slider.value))

    def _typed(self, value: float | None) -> None:
        if value is not None:
            self._bench.change(height_m=round(value / _MM, 6))


def _share(rest: RestPreview, height_m: float) -> float:
    """Return how far up in the picture from the side a height is, per cent, at most a little above its edges."""
    _, _, bottom, top = rest.side_m
    return min(110.0, max(-5.0, 100.0 * (height_m - bottom) / max(top - bottom, 1e-6)))


def _in_words(plane: PlaneSight | None, plan: Plan) -> str:
    """Describe what the lidar sees at the chosen height, and what it would see at the suggestion."""
    if plane is None:
        return ""
    pairs = (
        "" if sum(len(rest.poses) for rest in plan.rests) == 1 else f", distinguishes {plane.pairs:.0%} of the pairs"
    )
    unseen = f"; it misses {listed(plane.unseen, 4)}" if plane.unseen else ""
    text = f"At {_MM * plane.height_m:g} mm the lidar sees the object at {plane.seen:.0%} of the poses{pairs}{unseen}."
    best = plan.suggested
    if best is None or best.height_m == plane.height_m:
        return text
    return f"{text} At {_MM * best.height_m:g} mm, the suggestion: {best.seen:.0%}, {best.pairs:.0%}."
