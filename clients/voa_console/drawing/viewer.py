"""Scene of a session in a page: drawn once, then changed shape by shape, with the labels of what a person points at."""

from collections.abc import Awaitable, Callable, Iterable

from nicegui import ui
from nicegui.events import SceneClickEventArguments, SceneDragEventArguments

from voa_console.drawing.differences import Key, differences, key_of
from voa_console.drawing.drawn_shapes import Handle, MeshUrl, draw, place
from voa_scene.shapes import AnyShape, Scene, Text

Dragged = Callable[[AnyShape, float, float], Awaitable[None]]
"""Function that receives a shape and the x and y, metres, to which a person dragged it."""
_FRAMES_PER_S, _IDLE_FRAMES_PER_S = 30, 8
"""Frames per second while the pointer is over the scene, and otherwise, because pages stay open for days."""
_NEAR_M = 0.02
_NEARER = 0.12
"""Distance by which the camera looks to the near side of a point, as a share of its distance from it."""
_REST = "pointerrest"
_REST_JS = """(event) => {
  clearTimeout(window.pointerRest);
  const {clientX, clientY, target} = event;
  window.pointerRest = setTimeout(
    () => target.dispatchEvent(new MouseEvent("pointerrest", {clientX, clientY, bubbles: true})), 120);
}"""
"""Script that reports where the pointer rests, instead of every movement of it."""


class Viewer:
    """Three-dimensional view of a scene.

    Args:
        mesh_url: address of the mesh of an object.
        can_be_dragged: True for shapes that a person may drag over the table.
        on_drag: receives a shape that was dragged, with its new x and y.
        name: of the view for screen readers.
    """

    def __init__(
        self,
        mesh_url: MeshUrl,
        *,
        can_be_dragged: Callable[[AnyShape], bool] = lambda _: False,
        on_drag: Dragged | None = None,
        name: str = "Scene",
    ) -> None:
        self._mesh_url = mesh_url
        self._can_be_dragged = can_be_dragged
        self._on_drag = on_drag
        self._shown = Scene(())
        self._hidden: set[str] = set()
        self._handles: dict[Key, Handle] = {}
        self.element = ui.scene(
            grid=False,
            camera=ui.scene.perspective_camera(fov=50, near=_NEAR_M, far=60),
            on_click=self._point_at,
            click_events=["click", _REST],
            on_drag_end=self._drag,
            drag_constraints="z = 0",
            background_color="#f2f3f5",
            fps=_IDLE_FRAMES_PER_S,
        ).classes("w-full h-full dark:brightness-75")
        self.element.props("role=img").props["aria-label"] = name
        self.element.on("pointermove", js_handler=_REST_JS)
        self.element.on("pointerenter", lambda: self._set_rate(_FRAMES_PER_S))
        self.element.on("pointerleave", lambda: self._set_rate(_IDLE_FRAMES_PER_S))
        self.label = ui.label("").props("aria-live=polite")

    def look_at(self, middle: tuple[float, float], distance: float, height: float) -> None:
        """Move the camera to the south of a point of the table, and let it look at that point.

        Args:
            middle: x and y of the point, metres.
            distance: of the camera from the point, along the table, metres.
            height: of the camera, metres.
        """
        x, y = middle
        ahead = y - _NEARER * distance  # places in front of the point come near the camera, and need more room
        self.element.move_camera(x, y - distance, height, x, ahead, 0.0, 0.0, 0.0, 1.0, duration=0.0)

    @property
    def shown(self) -> Scene:
        """Scene that is shown."""
        return self._shown

    def show(self, scene: Scene) -> None:
        """Show a scene; shapes that did not change are left as they are."""
        changes = differences(self._shown, scene)
        for key in changes.removed:
            self._delete(key)
        for shape in changes.added:
            self._draw(shape)
        for shape in changes.changed:
            self._handles[key_of(shape)] = place(self._handles[key_of(shape)], shape)
        self._shown = scene

    def hide(self, groups: Iterable[str]) -> None:
        """Hide the shapes of these groups, and show all others."""
        self._hidden = set(groups)
        for handle in self._handles.values():
            handle.carrier.visible(handle.shape.group not in self._hidden)

    def _set_rate(self, frames_per_s: int) -> None:
        self.element.props["fps"] = frames_per_s
        self.element.update()

    def _draw(self, shape: AnyShape) -> None:
        can_be_dragged = self._on_drag is not None and self._can_be_dragged(shape)
        handle = draw(self.element, shape, self._mesh_url, can_be_dragged=can_be_dragged)
        handle.body.with_name(_written(key_of(shape)))
        if shape.group in self._hidden:
            handle.carrier.visible(False)
        self._handles[key_of(shape)] = handle

    def _delete(self, key: Key) -> None:
        self._handles.pop(key).carrier.delete()

    def _point_at(self, event: SceneClickEventArguments) -> None:
        """Show the label of the nearest shape that has one."""
        for hit in event.hits:
            handle = next((each for each in self._handles.values() if each.body.id == hit.object_id), None)
            if handle is not None and handle.shape.label and not isinstance(handle.shape, Text):
                self.label.set_text(handle.shape.label)
                return
        self.label.set_text("")

    async def _drag(self, event: SceneDragEventArguments) -> None:
        """Put a dragged shape back to its place, and report where a person dragged it."""
        handle = next((each for each in self._handles.values() if each.carrier.id == event.object_id), None)
        if handle is None or self._on_drag is None:
            return
        place(handle, handle.shape)
        await self._on_drag(handle.shape, event.x, event.y)


def _written(key: Key) -> str:
    return "/".join(key)
