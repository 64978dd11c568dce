"""Section of the grasps: gripper, number, and where their scores come from."""

from nicegui import ui

from voa_console.new_object.bench import Bench
from voa_console.new_object.draft import GEOMETRIC, GRIPPERS, SIMULATED, Draft, attempts_in_all
from voa_console.new_object.fields import NumberField, heading

_OTHER = "another"
_USUAL_M = 0.05
_SOURCES = {
    SIMULATED: "Simulated: attempts in a physics simulation (minutes)",
    GEOMETRIC: "Geometric: a first guess from the shapes (seconds)",
}


class GraspsSection:
    """Section of the grasps.

    Args:
        bench: of the new object.
    """

    def __init__(self, bench: Bench) -> None:
        self._bench = bench
        with ui.card().classes("w-full gap-3"):
            heading("5. Grasps and their scores")
            with ui.row().classes("items-start gap-4"):
                self._gripper = (
                    ui.select({**GRIPPERS, _OTHER: "another parallel gripper"}, label="Gripper", on_change=self._chosen)
                    .props("dense outlined")
                    .classes("w-72 max-w-full")
                )
                self._opening = NumberField("Opening, mm", self._opening_mm, self._opened, low=1, high=200)
                self._grasps = NumberField("Most grasps", lambda: self._draft().grasps, self._counted, low=1, high=200)
            self._scores = ui.radio(_SOURCES, on_change=self._sourced).props('aria-label="Source of the scores"')
            with ui.row().classes("items-center gap-4"):
                self._attempts = NumberField(
                    "Attempts per cell", lambda: self._draft().attempts, self._tried, low=1, high=10_000
                )
                self._all = ui.label().props('aria-live="polite"')
            with ui.expansion("More about the object").classes("w-full"), ui.row().classes("gap-4"):
                self._more = [
                    NumberField(
                        "Density, kg/m³",
                        lambda: self._draft().density_kg_m3,
                        lambda value: self._state(density_kg_m3=value),
                        low=1,
                        high=30_000,
                    ),
                    NumberField(
                        "Friction",
                        lambda: self._draft().friction,
                        lambda value: self._state(friction=value),
                        low=0.01,
                        high=10,
                        step=0.1,
                    ),
                    NumberField(
                        "Spread, mm",
                        lambda: round(1e3 * self._draft().xy_m, 3),
                        lambda value: self._state(xy_m=None if value is None else round(value / 1e3, 6)),
                        low=0,
                        high=1_000,
                    ),
                    NumberField(
                        "Spread, degrees",
                        lambda: self._draft().yaw_deg,
                        lambda value: self._state(yaw_deg=value),
                        low=0,
                        high=180,
                    ),
                ]
        self.update()

    def update(self) -> None:
        """Show the draft."""
        draft = self._draft()
        gripper = draft.gripper if draft.gripper in GRIPPERS else _OTHER
        if self._gripper.value != gripper:
            self._gripper.set_value(gripper)
        self._opening.element.set_visibility(gripper == _OTHER)
        if self._scores.value != draft.scores:
            self._scores.set_value(draft.scores)
        for field in (self._opening, self._grasps, self._attempts, *self._more):
            field.update()
        self._attempts.element.set_visibility(draft.scores == SIMULATED)
        plan = self._bench.previews.plan
        poses = 0 if plan is None else sum(len(rest.poses) for rest in plan.rests)
        attempts = attempts_in_all(draft, poses)
        self._all.set_text(f"at most {attempts:,} attempts in all".replace(",", " ") if attempts else "")

    def _draft(self) -> Draft:
        return self._bench.draft or Draft(mesh="")

    def _opening_mm(self) -> float | None:
        gripper = self._draft().gripper
        return None if gripper in GRIPPERS else round(1e3 * float(gripper), 3)

    def _opened(self, value: float | None) -> None:
        if value is not None:
            self._bench.change(gripper=f"{value / 1e3:g}")

    def _chosen(self) -> None:
        if self._gripper.value in GRIPPERS:
            self._bench.change(gripper=self._gripper.value)
        elif self._gripper.value == _OTHER and self._draft().gripper in GRIPPERS:
            self._bench.change(gripper=f"{_USUAL_M:g}")

    def _counted(self, value: float | None) -> None:
        self._state(grasps=None if value is None else int(value))

    def _tried(self, value: float | None) -> None:
        self._state(attempts=None if value is None else int(value))

    def _sourced(self) -> None:
        if self._scores.value in _SOURCES:
            self._bench.change(scores=self._scores.value)

    def _state(self, **choice: float | None) -> None:
        """Change a choice that has a value."""
        if None not in choice.values():
            self._bench.change(**choice)
