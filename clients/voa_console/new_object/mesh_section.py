"""Section of the mesh: its unit and the axis that points up, with the size that follows from them."""

from nicegui import ui

from voa_console.new_object.bench import Bench
from voa_console.new_object.draft import UNITS, describe_size, size_cm
from voa_console.new_object.fields import NumberField, heading, notice
from voa_setup.previews.messages import MeshMeasure

_OTHER = 0.0
_UPS = {"+Z": "z of the file", "+Y": "y of the file"}


class MeshSection:
    """Section of the mesh.

    Args:
        bench: of the new object.
    """

    def __init__(self, bench: Bench) -> None:
        self._bench = bench
        measure = bench.previews.measure
        assert measure is not None  # noqa: S101 - a draft has one
        self._measure = measure
        with ui.card().classes("w-full gap-3"):
            heading("1. Mesh")
            ui.label(f"{measure.name}, {measure.faces} triangles")
            self._doubt = ui.element("div")
            if 1.0 not in measure.scales:
                with self._doubt:
                    notice(_doubt(measure))
            with ui.row().classes("items-end gap-4 w-full"):
                self._unit = (
                    ui.select(self._units(), label="Unit of the file", value=self._unit_now(), on_change=self._chosen)
                    .props("dense outlined")
                    .classes("w-52")
                )
                self._scale = NumberField(
                    "Metres per unit", self._scale_now, self._typed, low=1e-6, high=1e3, step=0.001
                )
                self._up = (
                    ui.select(_UPS, label="Up is", value=self._up_now(), on_change=self._turned)
                    .props("dense outlined")
                    .classes("w-40")
                )
            self._size = ui.label().classes("text-base").props('aria-live="polite"')
            self._confirm = ui.button("Use this size", on_click=lambda: bench.change(confirmed=True))
        self.update()

    def update(self) -> None:
        """Show the draft."""
        draft = self._bench.draft
        assert draft is not None  # noqa: S101 - the section has a draft
        for element, value in ((self._unit, self._unit_now()), (self._up, draft.up)):
            if element.value != value:
                element.set_value(value)
        self._scale.update()
        self._scale.element.set_visibility(self._unit_now() == _OTHER)
        self._size.set_text(describe_size(self._measure, draft.scale, draft.up))
        self._confirm.set_visibility(not draft.confirmed)
        self._doubt.set_visibility(not draft.confirmed)

    def _units(self) -> dict[float, str]:
        """Return the units with the largest extent that follows from each."""
        sizes = {scale: max(size_cm(self._measure, scale, "+Z")) for scale in UNITS}
        return {scale: f"{name} ({sizes[scale]:.3g} cm)" for scale, name in UNITS.items()} | {_OTHER: "another"}

    def _scale_now(self) -> float:
        return 1.0 if self._bench.draft is None else self._bench.draft.scale

    def _unit_now(self) -> float:
        scale = self._scale_now()
        return scale if scale in UNITS else _OTHER

    def _up_now(self) -> str:
        return "+Z" if self._bench.draft is None else self._bench.draft.up

    def _chosen(self) -> None:
        if self._unit.value in UNITS and self._unit.value != self._scale_now():
            self._bench.change(scale=self._unit.value)
        self._scale.element.set_visibility(self._unit.value == _OTHER)

    def _typed(self, value: float | None) -> None:
        if value is not None:
            self._bench.change(scale=value)

    def _turned(self) -> None:
        self._bench.change(up=self._up.value)


def _doubt(measure: MeshMeasure) -> str:
    """Say why the file is probably not in metres, and which unit is probable instead."""
    largest = max(measure.extents)
    unit = UNITS.get(measure.scales[0]) if measure.scales else None
    guess = "state the metres per unit" if unit is None else f"it is probably in {unit}. Is that right?"
    return (
        f"If the file were in metres, the object would measure {largest:.4g} m, which is no object for an arm: {guess}"
    )
