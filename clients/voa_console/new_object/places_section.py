"""Section of the places: a map on which they are dragged along their circle, and fields that do so by keyboard."""

import math
from typing import Any, NamedTuple

from nicegui import events, ui

from voa_console.new_object.bench import Bench
from voa_console.new_object.draft import Draft, bearings_of, place_name, with_bearing
from voa_console.new_object.fields import NumberField, heading
from voa_console.new_object.pictures import MAP, bearing_at, map_of_places, place_at
from voa_msgs.lidars import LidarPreset
from voa_setup.previews.messages import PlannedPlace

_THROTTLE_S = 0.05
_USUAL_RADIUS_M = 0.45


class PlacesSection:
    """Section of the places.

    Args:
        bench: of the new object.
        lidars: presets of the service.
    """

    def __init__(self, bench: Bench, lidars: list[LidarPreset]) -> None:
        self._bench = bench
        self._moved: int | None = None
        self._dragged: Draft | None = None
        self._bearings: list[NumberField] = []
        with ui.card().classes("w-full gap-3"):
            heading("3. Places of the lidar")
            ui.label("Drag a place along the circle, or state its bearing. The lines are what the lidar can see.")
            with ui.row().classes("w-full gap-6 items-start"):
                self._map = ui.interactive_image(
                    size=(MAP, MAP), events=["pointerdown", "pointermove", "pointerup"], sanitize=False
                ).props('role="img" aria-label="Map of the places around the object"')
                self._map.style(f"width: min({MAP}px, 100%); touch-action: none; cursor: grab;")
                self._map.on("mouse", self._pointed, throttle=_THROTTLE_S)
                with ui.column().classes("gap-3 grow min-w-0"):
                    self._lidar = (
                        ui.select({lidar.name: lidar.title for lidar in lidars}, label="Lidar", on_change=self._chosen)
                        .props("dense outlined")
                        .classes("w-72 max-w-full")
                    )
                    with ui.row().classes("gap-3"):
                        self._number = NumberField("Number of places", self._count, self._counted, low=1, high=64)
                        self._radius = NumberField(
                            "Radius, cm", self._radius_cm, self._widened, low=1, high=10_000, hint="from the middle"
                        )
                    self._even = ui.button("Even ring", on_click=lambda: bench.change(bearings_deg=None)).props("flat")
                    ui.label("Bearings, degrees from +x").classes("text-sm opacity-70")
                    self._list = ui.row().classes("gap-2")
        self.update()

    def update(self) -> None:
        """Show the draft."""
        draft = self._bench.draft
        if draft is None:
            return
        if self._lidar.value != draft.lidar and draft.lidar in self._lidar.options:
            self._lidar.set_value(draft.lidar)
        self._number.update()
        self._radius.update()
        self._even.set_visibility(draft.bearings_deg is not None)
        self._list_bearings(draft)
        self._draw(self._dragged or draft)

    def _list_bearings(self, draft: Draft) -> None:
        """Draw a field for each place, again where their number has changed."""
        if len(self._bearings) == len(bearings_of(draft)):
            for field in self._bearings:
                field.update()
            return
        self._list.clear()
        with self._list:
            self._bearings = [self._bearing_field(index) for index in range(len(bearings_of(draft)))]

    def _bearing_field(self, index: int) -> NumberField:
        def read() -> float | None:
            draft = self._bench.draft
            bearings = () if draft is None else bearings_of(draft)
            return bearings[index] if index < len(bearings) else None

        def write(value: float | None) -> None:
            draft = self._bench.draft
            if value is not None and draft is not None:
                self._keep(with_bearing(draft, index, value, self._radius_now(draft)))

        field = NumberField(f"Place {index + 1}", read, write, low=0.0, high=360.0)
        field.element.classes(replace="w-24")
        return field

    def _draw(self, draft: Draft) -> None:
        previews, radius = self._bench.previews, self._radius_now(draft)
        outlines = [] if previews.outlines is None else previews.outlines.rests
        places = [_place(bearing, radius) for bearing in bearings_of(draft)]
        content = map_of_places(places, outlines, radius, self._moved)
        if self._map.content != content:
            self._map.set_content(content)

    def _pointed(self, event: events.GenericEventArguments) -> None:
        """Move the place under the pointer while its button is down, and to where it is released."""
        draft, point = self._bench.draft, _point(event.args)
        if draft is None or point is None:
            return
        if point.is_down and self._moved is None:
            self._moved = place_at(point.x, point.y, bearings_of(draft))
        if self._moved is None:
            return
        if point.is_down or point.is_released:  # the last move before a release may have been too quick to be sent
            bearing = bearing_at(point.x, point.y)
            self._dragged = with_bearing(draft, self._moved, bearing, self._radius_now(draft))
        if point.is_down and self._dragged is not None:
            self._draw(self._dragged)
            return
        dragged, self._dragged, self._moved = self._dragged, None, None
        if dragged is not None:
            self._keep(dragged)
        self.update()

    def _keep(self, draft: Draft) -> None:
        self._bench.change(bearings_deg=draft.bearings_deg, radius_m=draft.radius_m)

    def _radius_now(self, draft: Draft) -> float:
        """Return the radius of the circle: the stated radius, or that of the plan, metres."""
        plan = self._bench.previews.plan
        if draft.radius_m is not None:
            return draft.radius_m
        if plan is not None and plan.places:
            return round(math.hypot(plan.places[0].x, plan.places[0].y), 3)
        return _USUAL_RADIUS_M

    def _radius_cm(self) -> float | None:
        draft = self._bench.draft
        return None if draft is None else round(100.0 * self._radius_now(draft), 3)

    def _widened(self, value: float | None) -> None:
        if value is not None:
            self._bench.change(radius_m=round(value / 100.0, 5))

    def _count(self) -> float | None:
        return None if self._bench.draft is None else len(bearings_of(self._bench.draft))

    def _counted(self, value: float | None) -> None:
        if value is not None:
            self._bench.change(places=int(value), bearings_deg=None)

    def _chosen(self) -> None:
        if self._lidar.value is not None:
            self._bench.change(lidar=self._lidar.value)


def _place(bearing_deg: float, radius_m: float) -> PlannedPlace:
    """Return the place at a bearing, with the lidar's beam 0 towards the middle."""
    angle = math.radians(bearing_deg)
    return PlannedPlace(
        name=place_name(bearing_deg),
        x=radius_m * math.cos(angle),
        y=radius_m * math.sin(angle),
        yaw_rad=angle + math.pi,
    )


class _Pointer(NamedTuple):
    """Position of the pointer on the map, whether its button is down, and whether it is released just now."""

    x: float
    y: float
    is_down: bool
    is_released: bool


def _point(arguments: Any) -> _Pointer | None:
    """Return what an event says of the pointer; None: it does not say where it is."""
    try:
        x, y, is_down = float(arguments["image_x"]), float(arguments["image_y"]), bool(int(arguments["buttons"]) & 1)
    except (KeyError, TypeError, ValueError):
        return None
    return _Pointer(x, y, is_down, arguments.get("mouse_event_type") == "pointerup")
