"""The scene of a session in its page, with switches that hide parts of it."""

from collections.abc import Sequence
from itertools import chain

from nicegui import ui

from voa_console.drawing.meshes import mesh_url
from voa_console.drawing.viewer import Dragged, Viewer
from voa_console.session.facts import Facts, view_of
from voa_scene.colours import BLUE, GREEN, GREY, ORANGE, SKY_BLUE
from voa_scene.measures import measures_of
from voa_scene.scene import scene_of
from voa_scene.shapes import AnyShape, Cylinder, Scene

_GROUPS = {
    "belief": "Object at its poses",
    "looks": "Places and their VOA",
    "scan": "Newest scan",
    "robot": "Robots",
    "grasp": "Best grasp",
}
"""Groups of shapes that a person can hide, with their names."""
_LEGEND = (
    (ORANGE, "likeliest pose, and the outline that it predicts"),
    (GREY, "other poses"),
    (BLUE, "beams that returned; best grasp; recommended place"),
    (SKY_BLUE, "places about equal to the best"),
    (GREEN, "workspace, and beams that met nothing in it"),
)
_VIEWS = {"From the side": (1.65, 1.4), "From above": (0.01, 2.6)}
"""Views of the scene by name: distance and height of the camera, as multiples of the reach."""


class ScenePanel:
    """Scene of a session, its legend and its switches.

    Args:
        on_drag: receives the place whose tower a person dragged, and where to.
    """

    def __init__(self, on_drag: Dragged) -> None:
        self._facts: Facts | None = None
        self._extra: dict[str, tuple[AnyShape, ...]] = {}
        self._reach: float | None = None
        with ui.card().classes("w-full p-2 gap-1").props('role="region" aria-label="Scene"'):
            with ui.element("div").classes("w-full h-[340px] sm:h-[560px] overflow-hidden rounded"):
                self.viewer = Viewer(
                    mesh_url, can_be_dragged=self._is_tower, on_drag=on_drag, name="Scene of the session"
                )
            self.viewer.label.classes("h-6 text-sm font-medium truncate w-full")
            with ui.row().classes("w-full items-center gap-x-3 gap-y-0"):
                self._switches = {
                    group: ui.checkbox(name, value=True, on_change=self._hide).props("dense").classes("text-sm")
                    for group, name in _GROUPS.items()
                }
                for name in _VIEWS:
                    ui.button(name, on_click=lambda _, chosen=name: self._look(chosen), color=None).props(
                        "outline dense no-caps"
                    ).classes("px-2")
            self._legend = ui.row().classes("w-full items-center gap-x-4 gap-y-0 text-xs")
            with self._legend:
                for colour, meaning in _LEGEND:
                    with ui.row().classes("items-center gap-1 no-wrap"):
                        ui.element("div").classes("rounded-full").style(
                            f"width: 0.6rem; height: 0.6rem; background: {colour.hex}"
                        )
                        ui.label(meaning)

    def update(self, facts: Facts) -> None:
        """Show the scene of facts."""
        self._facts = facts
        measures = measures_of(facts.scenario)
        if self._reach is None:
            self._reach = measures.reach
            self._look("From the side")
        extra = () if facts.moment.is_past else chain.from_iterable(self._extra.values())
        self.viewer.show(Scene((*scene_of(view_of(facts)).shapes, *extra)))

    def add(self, owner: str, shapes: Sequence[AnyShape]) -> None:
        """Show further shapes, instead of those that the same owner added before.

        Args:
            owner: name of the part of the page that adds them.
            shapes: to show; empty: none.
        """
        self._extra[owner] = tuple(shapes)
        if self._facts is not None:
            self.update(self._facts)

    def _is_tower(self, shape: AnyShape) -> bool:
        """True for the tower of a listed place."""
        listed = [] if self._facts is None else [sensor.name for sensor in self._facts.scenario.sensors]
        return isinstance(shape, Cylinder) and shape.group == "looks" and shape.name in listed

    def _hide(self) -> None:
        self.viewer.hide(group for group, switch in self._switches.items() if not switch.value)

    def _look(self, name: str) -> None:
        distance, height = _VIEWS[name]
        reach = self._reach or 0.5
        middle = (0.0, 0.0) if self._facts is None else measures_of(self._facts.scenario).middle
        self.viewer.look_at(middle, distance * reach, height * reach)
