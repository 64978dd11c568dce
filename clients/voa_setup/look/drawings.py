"""Drawings of a scenario as PNG files: rests, outlines at each pose, grasps, and places with their VOA.

Letters stay legible where a telephone shrinks a drawing to its width.
"""

import math
from collections.abc import Mapping, Sequence
from pathlib import Path

import numpy as np
from matplotlib import rc_context
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import Circle, Rectangle
from matplotlib.ticker import MaxNLocator

from voa_client.formatting import signed
from voa_fleet.show.figures import new_figure
from voa_fleet.world.frames import Floats
from voa_fleet.world.meshes import Mesh
from voa_fleet.world.objects import GripperSetting
from voa_msgs.grasp_geometry import GraspGeometry
from voa_msgs.rankings import Look, Ranking
from voa_msgs.scenarios import ScenarioRequest
from voa_setup.look.glyphs import gripper_glyph
from voa_setup.look.panels import (
    BLUE,
    GREY,
    MM,
    ORANGE,
    Box,
    box_around,
    draw_gripper,
    draw_mesh,
    draw_outline,
    draw_outlines_of,
    draw_scan_planes,
    draw_table,
    finish,
)
from voa_setup.look.views import front_view, top_view, view_across_fingers

_DPI = 150
_WIDTH_IN = 3.6
"""Width of a drawing that stands beside another: 540 pixels."""
_HIGH = 1.5
"""Height of two panels below one another, as a share of their width, above which they stand beside one another."""
_LEFT_IN, _EDGE_IN, _BELOW_IN, _ABOVE_IN = 0.52, 0.12, 0.45, 0.27
"""Room around a panel for its labels, inches."""
_COLUMNS = 3
_LABELLED, _WITH_ARROWS = 24, 200
"""Most places that get a label, and an arrow."""
_ARROW_M = 0.06
_LARGEST = 0.04
"""Radius of the disc of the largest VOA, as a share of the map's size."""


def draw_rest(file: Path, mesh: Mesh, heights_m: Sequence[float], outlines: Sequence[Floats]) -> None:
    """Draw an object at rest from the front, with the scan planes, and from above, with its outline in each.

    Args:
        file: the PNG file.
        mesh: in the world frame.
        heights_m: heights of the scan planes.
        outlines: at each height (s, 2, 2) segments, metres; s = 0 where the plane misses the object.
    """
    front, top = front_view(), top_view()
    planes = np.column_stack([np.full(len(heights_m), mesh.vertices[:, 0].mean()), heights_m])
    ground = [[float(mesh.vertices[:, 0].mean()), 0.0]]
    sides = box_around(np.concatenate([front.project(mesh.vertices), planes.reshape(-1, 2), ground]))
    above = box_around(top.project(mesh.vertices))
    sides, above = _of_one_width(sides, above)
    first, second, figure = _two_panels(sides, above)
    draw_table(first, sides)
    draw_mesh(first, mesh, front, 420)
    draw_scan_planes(first, heights_m)
    finish(first, sides, front, "from the front")
    draw_mesh(second, mesh, top, 420, opacity=0.45)
    draw_outlines_of(second, outlines)
    finish(second, above, top, "from above")
    figure.savefig(file, dpi=_DPI)


def _of_one_width(first: Box, second: Box) -> tuple[Box, Box]:
    """Widen two boxes to the same left and right edge."""
    left, right = min(first.left, second.left), max(first.right, second.right)
    return Box(left, right, first.bottom, first.top), Box(left, right, second.bottom, second.top)


def draw_grasp(file: Path, mesh: Mesh, geometry: GraspGeometry, gripper: GripperSetting) -> None:
    """Draw a gripper that has closed on an object, from the side on which both fingers are seen, and from above.

    Args:
        file: the PNG file.
        mesh: of the object in the world frame.
        geometry: of the grasp.
        gripper: sizes of the fingers.
    """
    glyph = gripper_glyph(geometry, gripper)
    side, top = view_across_fingers(geometry), top_view()
    points = np.concatenate([mesh.vertices, glyph.points])
    ground = side.project(np.append(mesh.vertices[0, :2], 0.0))[None]
    sides, above = box_around(np.concatenate([side.project(points), ground])), box_around(top.project(points))
    first, second, figure = _two_panels(sides, above)
    draw_table(first, sides)
    for axes, view, box, title in ((first, side, sides, "from the side"), (second, top, above, "from above")):
        draw_mesh(axes, mesh, view, 260)
        draw_gripper(axes, glyph, view)
        finish(axes, box, view, title)
    figure.savefig(file, dpi=_DPI)


def _two_panels(first: Box, second: Box) -> tuple[Axes, Axes, Figure]:
    """Make two panels of one scale, below one another or, if that would be too high, beside one another."""
    if first.height + second.height <= _HIGH * max(first.width, second.width):
        scale = (_WIDTH_IN - _LEFT_IN - _EDGE_IN) / max(first.width, second.width)
        corners = [(_LEFT_IN, second.height * scale + 2.0 * _BELOW_IN + _ABOVE_IN), (_LEFT_IN, _BELOW_IN)]
        height = (first.height + second.height) * scale + 2.0 * (_BELOW_IN + _ABOVE_IN)
    else:
        scale = (_WIDTH_IN - 2.0 * (_LEFT_IN + _EDGE_IN)) / (first.width + second.width)
        corners = [(_LEFT_IN, _BELOW_IN), (2.0 * _LEFT_IN + _EDGE_IN + first.width * scale, _BELOW_IN)]
        height = max(first.height, second.height) * scale + _BELOW_IN + _ABOVE_IN
    figure = new_figure(_WIDTH_IN, height, layout=None)
    size = np.array([_WIDTH_IN, height, _WIDTH_IN, height])
    panels = []
    for (left, bottom), box in zip(corners, (first, second), strict=True):
        width_in, height_in = box.width * scale, box.height * scale
        axes = figure.add_axes(tuple(np.array([left, bottom, width_in, height_in]) / size))
        axes.xaxis.set_major_locator(MaxNLocator(max(2, int(width_in / 0.4))))
        axes.yaxis.set_major_locator(MaxNLocator(max(2, int(height_in / 0.3))))
        panels.append(axes)
    return panels[0], panels[1], figure


@rc_context({"text.parse_math": False})  # names may have dollar signs
def draw_outlines(file: Path, names: Sequence[str], outlines: Sequence[Sequence[Floats]]) -> None:
    """Draw the outline that the lidar sees at each pose, all of one scale, around the world's origin (cross).

    Args:
        file: the PNG file.
        names: of the poses.
        outlines: of each pose (outer) in each scan plane (inner), (s, 2, 2) segments, metres.
    """
    corners = np.concatenate([np.zeros((1, 2)), _corners(outlines)])
    box = box_around(corners, 0.06)
    columns = min(_COLUMNS, len(names))
    rows = math.ceil(len(names) / columns)
    label = 0.16 * box.width
    step = np.array([box.width, box.height + label])
    width_in = 1.25 * columns
    figure = new_figure(width_in, width_in * rows * step[1] / (columns * step[0]), layout=None)
    axes = figure.add_axes((0.0, 0.0, 1.0, 1.0))
    axes.axis("off")
    for index, (name, of_pose) in enumerate(zip(names, outlines, strict=True)):
        corner = np.array([index % columns, -(index // columns) - 1]) * step
        shift = corner - np.array([box.left, box.bottom])
        axes.plot(*(MM * shift), marker="+", color=GREY, markersize=5)
        draw_outlines_of(axes, of_pose, shift)
        text = name if any(len(segments) for segments in of_pose) else f"{name}: nothing"
        middle = MM * (corner + np.array([box.width / 2.0, box.height + 0.3 * label]))
        axes.text(middle[0], middle[1], _shortened(text), ha="center", va="center", fontsize=8)
        frame = (MM * corner[0], MM * corner[1])
        axes.add_patch(Rectangle(frame, *(MM * step), fill=False, edgecolor="#d0d5da", linewidth=0.8))
    axes.set_xlim(0.0, MM * columns * step[0])
    axes.set_ylim(-MM * rows * step[1], 0.0)
    figure.savefig(file, dpi=_DPI)


def _corners(outlines: Sequence[Sequence[Floats]]) -> Floats:
    """Ends of all segments of outlines, (k, 2), metres."""
    return np.concatenate([np.zeros((0, 2)), *(part.reshape(-1, 2) for of_pose in outlines for part in of_pose)])


def _shortened(text: str, most: int = 20) -> str:
    return text if len(text) <= most else f"{text[: most - 1]}…"


@rc_context({"text.parse_math": False})  # names may have dollar signs
def draw_places(
    file: Path, scenario: ScenarioRequest, outlines: Sequence[Sequence[Floats]], ranking: Ranking | None
) -> None:
    """Draw the places around the object from above, each as a disc whose area is its VOA, the recommended one orange.

    Places above one another share a label.

    Args:
        file: the PNG file.
        scenario: with the places.
        outlines: of the object at each pose (outer) in each scan plane (inner), (s, 2, 2) segments, metres.
        ranking: with the VOA of the places; None: not known.
    """
    stands = np.array([[sensor.x, sensor.y] for sensor in scenario.sensors])
    seen = _corners(outlines)
    middle = (seen if len(seen) else stands).mean(axis=0)
    box = box_around(np.concatenate([stands, seen]), 0.16)
    figure = new_figure(4.0, 4.0 * box.height / box.width + 0.3)
    axes = figure.subplots()
    for of_pose in outlines:
        for segments in of_pose:
            draw_outline(axes, segments, "#555555", width=0.8, opacity=max(0.15, 1.0 / len(outlines)))
    _draw_workspace(axes, scenario)
    voa = {} if ranking is None else {look.sensor: look.voa for look in ranking.ranking}
    chosen = None
    if ranking is not None and isinstance(ranking.recommendation, Look):
        chosen = ranking.recommendation.sensor
    largest = _LARGEST * max(box.width, box.height)
    arrows = len(scenario.sensors) <= _WITH_ARROWS
    labels: dict[tuple[float, float], list[str]] = {}
    for sensor in sorted(scenario.sensors, key=lambda sensor: sensor.name == chosen):  # the chosen one on top
        colour = ORANGE if sensor.name == chosen else BLUE
        _draw_place(axes, (sensor.x, sensor.y, sensor.yaw_rad), _radius(voa, sensor.name, largest), colour, arrows)
    for sensor in scenario.sensors:
        value = f" {signed(voa[sensor.name], 2)}" if sensor.name in voa else ""
        labels.setdefault((round(sensor.x, 2), round(sensor.y, 2)), []).append(_shortened(sensor.name) + value)
    if len(labels) <= _LABELLED:
        for stand, texts in labels.items():
            _label(axes, np.array(stand), middle, "\n".join(texts), box, largest)
    finish(axes, box, top_view(), "")
    axes.set_aspect("equal")
    figure.savefig(file, dpi=_DPI)


def _draw_workspace(axes: Axes, scenario: ScenarioRequest) -> None:
    """Draw the rectangle outside of which returns are ignored, dashed."""
    space = scenario.workspace
    if space is not None:
        corner, size = np.asarray(space.min), np.subtract(space.max, space.min)
        axes.add_patch(
            Rectangle(
                (MM * corner[0], MM * corner[1]), *(MM * size), fill=False, edgecolor=GREY, linestyle=":", linewidth=1.0
            )
        )


def _radius(voa: Mapping[str, float], name: str, largest: float) -> float:
    """Radius of a place's disc, metres: its area is proportional to the VOA."""
    most = max([*voa.values(), 0.0])
    if most <= 0.0 or name not in voa:
        return 0.0
    return largest * math.sqrt(max(voa[name], 0.0) / most)


def _draw_place(axes: Axes, stand: tuple[float, float, float], radius: float, colour: str, arrow: bool) -> None:
    x, y, yaw = stand
    axes.add_patch(Circle((MM * x, MM * y), MM * radius, facecolor=colour, edgecolor="none", alpha=0.45, zorder=3.0))
    axes.plot(MM * x, MM * y, marker="o", markersize=4, color=colour, zorder=5.0)
    if not arrow:
        return
    ahead = (MM * (x + _ARROW_M * math.cos(yaw)), MM * (y + _ARROW_M * math.sin(yaw)))
    shape = {"arrowstyle": "->", "color": colour, "linewidth": 1.2, "shrinkA": 0.0, "shrinkB": 0.0}
    axes.annotate("", xy=ahead, xytext=(MM * x, MM * y), arrowprops=shape, zorder=4.0)


def _label(axes: Axes, stand: Floats, middle: Floats, text: str, box: Box, largest: float) -> None:
    """Write a label above a place, or below one on the near side of the object, so that it stays within the map."""
    across = (float(stand[0]) - box.left) / box.width
    side, shift = ("left", -1.0) if across < 0.35 else ("right", 1.0) if across > 0.65 else ("center", 0.0)
    above = 1.0 if stand[1] >= middle[1] else -1.0
    at = MM * (stand + largest * np.array([shift, 1.1 * above]))
    level = "bottom" if above > 0.0 else "top"
    axes.text(at[0], at[1], text, ha=side, va=level, fontsize=8, zorder=6.0, linespacing=1.0)
