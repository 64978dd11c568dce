"""Points of a scan by class of beam, and the outline that the likeliest pose predicts."""

import math
from collections.abc import Iterator, Sequence
from typing import Literal

from voa_msgs.geometry import SensorPose
from voa_msgs.lidars import Lidar
from voa_msgs.scenarios import Scenario, Workspace
from voa_scene.colours import BLUE, GREEN, ORANGE, PURPLE
from voa_scene.shapes import AnyShape, Ball, Colour, Points, Polyline, Vector
from voa_scene.views import TakenScan

Class = Literal["return", "no-return", "missing"]
_LABELS: dict[Class, str] = {
    "return": "returns: the beam met something in the workspace",
    "no-return": "no-returns: the beam passed through the workspace and met nothing there",
    "missing": "missing: something stood before the workspace, which is no evidence",
}
_COLOURS: dict[Class, Colour] = {"return": BLUE, "no-return": GREEN, "missing": PURPLE}
_SIZES: dict[Class, float] = {"return": 0.006, "no-return": 0.004, "missing": 0.005}
_GAP_M = 0.05
"""Largest distance of two neighbouring predicted points that a line joins."""
_LIDAR_M = 0.012
_BELOW_M = 0.002
"""Height by which the predicted outline lies below the scan's points."""


def scan_shapes(scenario: Scenario, taken: TakenScan) -> list[AnyShape]:
    """Make the points of a scan, one shape per class of beam, and the predicted outline below them.

    Beams without a point in the scene, such as a no-return where there is no workspace, are left out.
    """
    height = taken.place.height_m if taken.place.height_m is not None else scenario.lidar.height_m
    level = height or 0.0
    by_class: dict[Class, list[Vector]] = {"return": [], "no-return": [], "missing": []}
    for kind, (x, y) in classified(taken, scenario.lidar, scenario.workspace):
        by_class[kind].append((x, y, level))
    shapes: list[AnyShape] = [
        Points(
            group="scan",
            name=kind,
            label=_LABELS[kind],
            points=tuple(points),
            size=_SIZES[kind],
            colour=_COLOURS[kind],
        )
        for kind, points in by_class.items()
        if points
    ]
    shapes.append(
        Ball(
            group="scan",
            name="lidar",
            label="lidar at the newest scan",
            position=(taken.place.x, taken.place.y, level),
            radius=_LIDAR_M,
            colour=BLUE,
        )
    )
    return shapes + _outline(taken, scenario.lidar, scenario.workspace, max(level - _BELOW_M, 0.0))


def classified(
    taken: TakenScan, lidar: Lidar, workspace: Workspace | None
) -> Iterator[tuple[Class, tuple[float, float]]]:
    """Yield the class of each beam that has a point, with the point, in the world frame, metres.

    The order of the tests is that of the service: a range of 0 and the limits of the scan, which come before those of
    the lidar, then the workspace. A no-return within a workspace has its point where the beam leaves it.

    Args:
        taken: the scan and its place.
        lidar: of the scenario, with all its fields.
        workspace: of the scenario; None: every return within range counts.
    """
    scan, place = taken.scan, taken.place
    near = scan.range_min if scan.range_min is not None else lidar.range_min or 0.0
    far = scan.range_max if scan.range_max is not None else lidar.range_max or math.inf
    empty = frozenset(scan.no_return)
    for index, (value, bearing) in enumerate(zip(scan.ranges, bearings(taken, lidar), strict=True)):
        enters, leaves = (0.0, math.inf) if workspace is None else crossing(workspace, place, bearing)
        if index in empty or (value == 0.0 and lidar.zero == "no_return") or (value is not None and value > far):
            distance = math.inf
        elif value is None or value == 0.0 or value < near:
            continue
        else:
            distance = value
        if distance < enters < leaves:
            yield "missing", _at(place, bearing, distance)
        elif distance <= leaves and enters < leaves and distance < math.inf:
            yield "return", _at(place, bearing, distance)
        elif enters < leaves < math.inf:
            yield "no-return", _at(place, bearing, leaves)


def bearings(taken: TakenScan, lidar: Lidar) -> list[float]:
    """Directions of the beams of a scan in the world frame, radians; fields that it does not state are the lidar's."""
    scan = taken.scan
    return _directions(
        len(scan.ranges),
        taken.place.yaw_rad,
        scan.angle_min if scan.angle_min is not None else lidar.angle_min or 0.0,
        scan.angle_increment if scan.angle_increment is not None else lidar.angle_increment or 0.0,
    )


def crossing(box: Workspace, place: SensorPose, bearing: float) -> tuple[float, float]:
    """Return the ranges at which a beam enters and leaves a box, metres; the first is larger if it never does."""
    enters, leaves = 0.0, math.inf
    towards = (math.cos(bearing), math.sin(bearing))
    for start, part, low, high in zip((place.x, place.y), towards, box.min, box.max, strict=True):
        if abs(part) < 1e-12:
            if not low <= start <= high:
                return math.inf, 0.0
            continue
        first, last = sorted(((low - start) / part, (high - start) / part))
        enters, leaves = max(enters, first), min(leaves, last)
    return enters, leaves


def _directions(beams: int, yaw: float, first: float, step: float) -> list[float]:
    return [yaw + first + step * index for index in range(beams)]


def _at(place: SensorPose, bearing: float, distance: float) -> tuple[float, float]:
    return (place.x + distance * math.cos(bearing), place.y + distance * math.sin(bearing))


def _outline(taken: TakenScan, lidar: Lidar, workspace: Workspace | None, level: float) -> list[AnyShape]:
    """Lines through neighbouring predicted points within the workspace."""
    directions = _directions(
        len(taken.predicted), taken.place.yaw_rad, lidar.angle_min or 0.0, lidar.angle_increment or 0.0
    )
    points = [
        None if distance is None else _inside(workspace, _at(taken.place, bearing, distance))
        for distance, bearing in zip(taken.predicted, directions, strict=True)
    ]
    return [
        Polyline(
            group="scan",
            name=f"predicted {number}",
            label="outline that the likeliest pose predicts",
            points=tuple((x, y, level) for x, y in piece),
            colour=ORANGE,
        )
        for number, piece in enumerate(_pieces(points))
    ]


def _inside(box: Workspace | None, point: tuple[float, float]) -> tuple[float, float] | None:
    """Return a point if it lies in the workspace, or there is none; else None."""
    if box is None or all(low <= part <= high for low, part, high in zip(box.min, point, box.max, strict=True)):
        return point
    return None


def _pieces(points: Sequence[tuple[float, float] | None]) -> list[list[tuple[float, float]]]:
    """Split points where one is None or far from the one before; pieces of fewer than two points are dropped."""
    pieces: list[list[tuple[float, float]]] = [[]]
    for point in points:
        if point is None or (pieces[-1] and math.dist(pieces[-1][-1], point) > _GAP_M):
            pieces.append([])
        if point is not None:
            pieces[-1].append(point)
    return [piece for piece in pieces if len(piece) > 1]
