"""Grasps: a parallel gripper that has closed, as two fingers, the bar that joins them, and the approach."""

from voa_msgs.grasp_geometry import GraspGeometry, grasp_geometry
from voa_msgs.scenarios import Grasp
from voa_scene.colours import BLUE
from voa_scene.rotations import along, cross, of_axes, unit
from voa_scene.shapes import AnyShape, Box, Polyline

_OPENING_M = 0.085
_FINGER_M = (0.012, 0.02, 0.05)
"""Thickness, width and length of a finger where the scenario does not state a gripper."""
_BAR_M = 0.008
_APPROACH_M = 0.12


def grasp_shapes(grasp: Grasp) -> list[AnyShape]:
    """Make the glyph of a grasp; none if its `data` does not follow the convention for a grasp's geometry."""
    try:
        geometry = grasp_geometry(grasp.data)
    except ValueError:
        return []
    return [] if geometry is None else _glyph(grasp.name, geometry)


def _glyph(name: str, geometry: GraspGeometry) -> list[AnyShape]:
    """Fingers at the width of the object between them, or open if it is not known."""
    approach, closing = unit(geometry.approach), unit(geometry.closing)
    rotation = of_axes(closing, cross(approach, closing), approach)
    centre = geometry.tool_centre_point
    thickness, width, length = _FINGER_M
    between = _OPENING_M if geometry.width_m is None else geometry.width_m
    middle = along(centre, approach, -length / 2.0)
    label = f"best grasp {name}"
    shapes: list[AnyShape] = [
        Box(
            group="grasp",
            name=f"finger {number}",
            label=label,
            position=along(middle, closing, side * (between + thickness) / 2.0),
            rotation=rotation,
            size=(thickness, width, length),
            colour=BLUE,
        )
        for number, side in ((1, -1.0), (2, 1.0))
    ]
    bar = Box(
        group="grasp",
        name="bar",
        label=label,
        position=along(centre, approach, -length - _BAR_M / 2.0),
        rotation=rotation,
        size=(between + 2.0 * thickness, width, _BAR_M),
        colour=BLUE,
    )
    start = along(centre, approach, -length - _APPROACH_M)
    line = Polyline(group="grasp", name="approach", label=label, points=(start, centre), colour=BLUE)
    return [*shapes, bar, line]
