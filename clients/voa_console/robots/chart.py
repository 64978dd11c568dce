"""Chart of a robot's scan from above: points, predicted outline, workspace, places and the lidar itself."""

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import Any, Literal

from voa_client import Scan, Scenario
from voa_console.robots.readings import AS_MEASURED, Reading, read
from voa_msgs.geometry import SensorPose, UncertainSensorPose
from voa_msgs.lidars import Lidar
from voa_scene.colours import BLUE, GREEN, GREY, ORANGE, VERMILION
from voa_scene.measures import measures_of
from voa_scene.scans import bearings, classified
from voa_scene.shapes import Colour
from voa_scene.views import TakenScan

Point = tuple[float, float]
Window = Literal["Object", "Table", "Room"]
"""Part of the world that a chart shows: the object, the places around the table, or every return."""
_MARGIN = 1.2
_SMALLEST_M = 0.3
_CLOSEST_M = 0.05
_MARGINS_PX = {"left": 52, "right": 16, "top": 16, "bottom": 52}
"""Both sums are equal, so that a square element has a square plot."""


@dataclass(frozen=True)
class Drawing:
    """Points of a chart, in the world frame, metres.

    Attributes:
        lidar: pose of the lidar as read.
        inside: returns in the workspace; all returns without a workspace.
        outside: other returns, such as walls.
        outline: predicted points, None between two pieces.
        pose: to which the outline belongs; None: there is none.
        scenario: whose workspace and places are drawn; None: there is none.
    """

    lidar: SensorPose
    inside: tuple[Point, ...]
    outside: tuple[Point, ...]
    outline: tuple[Point | None, ...]
    pose: str | None
    scenario: Scenario | None


def drawing_of(
    scan: Scan,
    place: UncertainSensorPose | None,
    scenario: Scenario | None,
    reading: Reading = AS_MEASURED,
    predicted: Sequence[float | None] = (),
    pose: str | None = None,
) -> Drawing:
    """Compute the points of a chart.

    Args:
        scan: of the robot.
        place: pose of the lidar, as stated; None: not known, and the scan is drawn around the origin.
        scenario: of the robot's session; None: there is none.
        reading: way to read the directions of the beams.
        predicted: ranges on the beams of the scenario's lidar from the place as read, metres.
        pose: to which the prediction belongs.
    """
    lidar = Lidar() if scenario is None else scenario.lidar
    scan, stand = read(reading, scan, place or UncertainSensorPose(x=0.0, y=0.0, yaw_rad=0.0), lidar)
    taken = TakenScan(scan, stand)
    every = [
        _point(stand, bearing, distance)
        for distance, bearing in zip(scan.ranges, bearings(taken, lidar), strict=True)
        if distance is not None and distance > 0.0
    ]
    if scenario is None:
        return Drawing(stand, tuple(every), (), (), None, None)
    inside = [point for kind, point in classified(taken, lidar, scenario.workspace) if kind == "return"]
    known = set(inside)
    outside = tuple(point for point in every if point not in known)
    return Drawing(stand, tuple(inside), outside, _outline(stand, lidar, predicted), pose, scenario)


def options(drawing: Drawing, window: Window) -> dict[str, Any]:
    """Make the options of ECharts.

    Args:
        drawing: points of the chart.
        window: part of the world that the axes cover.
    """
    (x, y), half = _window(drawing, window)
    return {
        "animation": False,
        "grid": {**_MARGINS_PX, "borderColor": GREY.hex},
        "tooltip": {"trigger": "item", "formatter": "{a}"},
        "xAxis": _axis("x, m", x, half),
        "yAxis": _axis("y, m", y, half),
        "series": [
            _line("workspace", _workspace(drawing.scenario), GREEN, dashed=True),
            _dots("places to look from", _places(drawing.scenario), GREY, 9, "emptyCircle"),
            _dots("other returns", drawing.outside, GREY, 3),
            _line("prediction", drawing.outline, ORANGE),
            _dots("returns in the workspace", drawing.inside, BLUE, 5),
            _line("direction of beam 0", _heading(drawing.lidar, half), VERMILION),
            _dots("lidar", [(drawing.lidar.x, drawing.lidar.y)], VERMILION, 12),
        ],
    }


def legend(drawing: Drawing) -> list[tuple[str, str]]:
    """Return the names and colours of what a chart shows, for a legend beside it."""
    shown = [
        ("returns in the workspace" if drawing.scenario else "returns", BLUE, drawing.inside),
        ("other returns", GREY, drawing.outside),
        (f"prediction of pose {drawing.pose!r}", ORANGE, drawing.outline),
        ("workspace", GREEN, _workspace(drawing.scenario)),
        ("lidar and its beam 0", VERMILION, (drawing.lidar,)),
    ]
    return [(name, colour.hex) for name, colour, points in shown if points]


def _axis(name: str, middle: float, half: float) -> dict[str, Any]:
    colour = GREY.hex
    return {
        "type": "value",
        "name": name,
        "nameLocation": "middle",
        "nameGap": 30,
        "min": round(middle - half, 4),
        "max": round(middle + half, 4),
        "axisLabel": {"color": colour, "showMinLabel": False, "showMaxLabel": False},
        "nameTextStyle": {"color": colour},
        "axisLine": {"onZero": False, "lineStyle": {"color": colour}},
        "splitLine": {"lineStyle": {"color": colour, "opacity": 0.2}},
    }


def _dots(name: str, points: Iterable[Point], colour: Colour, size: int, symbol: str = "circle") -> dict[str, Any]:
    return {
        "type": "scatter",
        "name": name,
        "symbol": symbol,
        "symbolSize": size,
        "itemStyle": {"color": colour.hex},
        "data": [[round(x, 4), round(y, 4)] for x, y in points],
    }


def _line(name: str, points: Iterable[Point | None], colour: Colour, *, dashed: bool = False) -> dict[str, Any]:
    return {
        "type": "line",
        "name": name,
        "showSymbol": False,
        "connectNulls": False,
        "lineStyle": {"color": colour.hex, "width": 2, "type": "dashed" if dashed else "solid"},
        "itemStyle": {"color": colour.hex},
        "data": [[None, None] if point is None else [round(point[0], 4), round(point[1], 4)] for point in points],
    }


def _window(drawing: Drawing, window: Window) -> tuple[Point, float]:
    """Return the middle of the chart, and half of its edge, metres."""
    lidar = (drawing.lidar.x, drawing.lidar.y)
    if drawing.scenario is None:
        middle, half = lidar, 0.0
    elif window == "Object":
        return _object(drawing, drawing.scenario)
    else:
        measures = measures_of(drawing.scenario)
        middle = measures.middle
        half = max(measures.reach, *(abs(a - b) for a, b in zip(lidar, middle, strict=True)))
    if window == "Room" or drawing.scenario is None:
        away = [max(abs(x - middle[0]), abs(y - middle[1])) for x, y in (*drawing.inside, *drawing.outside)]
        half = max([half, *away])
    return middle, _MARGIN * max(half, _SMALLEST_M)


def _object(drawing: Drawing, scenario: Scenario) -> tuple[Point, float]:
    """Window about the predicted outline and the returns in the workspace, or about the workspace if there are none."""
    points = [point for point in drawing.outline if point is not None]
    points += drawing.inside if scenario.workspace is not None else ()
    points = points or _workspace(scenario)
    if not points:
        return measures_of(scenario).middle, _SMALLEST_M
    (left, right), (low, high) = ((min(part), max(part)) for part in zip(*points, strict=True))
    half = max(right - left, high - low) / 2.0
    return ((left + right) / 2.0, (low + high) / 2.0), max(1.5 * half, _CLOSEST_M)


def _outline(stand: SensorPose, lidar: Lidar, predicted: Sequence[float | None]) -> tuple[Point | None, ...]:
    """Predicted points in the order of the beams, None where two neighbours do not belong together."""
    first, step = lidar.angle_min or 0.0, lidar.angle_increment or 0.0
    points: list[Point | None] = []
    for index, distance in enumerate(predicted):
        point = None if distance is None else _point(stand, stand.yaw_rad + first + step * index, distance)
        last = points[-1] if points else None
        if point is not None and last is not None and math.dist(point, last) > 0.05:
            points.append(None)
        if point is not None or last is not None:
            points.append(point)
    return tuple(points)


def _workspace(scenario: Scenario | None) -> list[Point]:
    if scenario is None or scenario.workspace is None:
        return []
    (left, low), (right, high) = scenario.workspace.min, scenario.workspace.max
    return [(left, low), (right, low), (right, high), (left, high), (left, low)]


def _places(scenario: Scenario | None) -> list[Point]:
    return [] if scenario is None else [(sensor.x, sensor.y) for sensor in scenario.sensors]


def _heading(lidar: SensorPose, half: float) -> list[Point]:
    return [(lidar.x, lidar.y), _point(lidar, lidar.yaw_rad, 0.2 * half)]


def _point(stand: SensorPose, bearing: float, distance: float) -> Point:
    return stand.x + distance * math.cos(bearing), stand.y + distance * math.sin(bearing)
