"""Shapes of the table and of the workspace."""

from voa_msgs.scenarios import Scenario
from voa_scene.colours import GREEN, TABLE
from voa_scene.measures import Measures
from voa_scene.shapes import AnyShape, Box, Polyline

_THICKNESS_M = 0.004
_ABOVE_M = 0.001


def table_of(scenario: Scenario, measures: Measures) -> list[AnyShape]:
    """Make the table, whose upper side is at z = 0, and the outline of the workspace if the scenario states one."""
    x, y = measures.middle
    edge = measures.table
    top: AnyShape = Box(
        group="table",
        name="table",
        position=(x, y, -_THICKNESS_M / 2.0),
        size=(edge, edge, _THICKNESS_M),
        colour=TABLE.faded(0.35),
    )
    space = scenario.workspace
    if space is None:
        return [top]
    (left, low), (right, high) = space.min, space.max
    corners = ((left, low), (right, low), (right, high), (left, high))
    outline = Polyline(
        group="table",
        name="workspace",
        label="workspace: returns from outside it are ignored",
        points=tuple((x, y, _ABOVE_M) for x, y in corners),
        closed=True,
        colour=GREEN,
    )
    return [top, outline]
