"""Places: towers as high as the Value of Assistance of a look from there."""

import math

from voa_msgs.geometry import SensorPose
from voa_msgs.rankings import Look, RankedSensor, Ranking
from voa_msgs.scenarios import Scenario
from voa_scene.colours import BLUE, GREY, SKY_BLUE
from voa_scene.measures import Measures
from voa_scene.shapes import AnyShape, Colour, Cylinder, Polyline, Text, Vector

_HEIGHT = 0.8
"""Height of a tower of VOA 1, as a share of the scene's reach: it is fixed, so that versions can be compared."""
_RADIUS = 0.035
_DISC = 0.004
_ARROW = 0.12
_ABOUT_EQUAL = "about equal to the best"


def places_of(scenario: Scenario, ranking: Ranking | None, measures: Measures) -> list[AnyShape]:
    """Make the towers of the places of a scenario, with error bars of two standard errors and their headings.

    Places that the ranking recommends are dark blue, places about equal to the first are light blue, others grey. A
    place without a positive VOA, or without a ranking, is a flat disc. Places that only the ranking has are not drawn.
    """
    ranked = {} if ranking is None else {look.sensor: look for look in ranking.ranking}
    chosen = recommended(ranking)
    shapes: list[AnyShape] = []
    for sensor in scenario.sensors:
        shapes += tower(sensor.name, sensor, ranked.get(sensor.name), measures, chosen=sensor.name in chosen)
    return shapes


def recommended(ranking: Ranking | None) -> tuple[str, ...]:
    """Return the names of the places that a ranking recommends to look from: none, one, or a pair."""
    if ranking is None or not isinstance(ranking.recommendation, Look):
        return ()
    advice = ranking.recommendation
    return (advice.sensor,) if advice.then is None else (advice.sensor, advice.then)


def tower(
    name: str, stand: SensorPose, look: RankedSensor | None, measures: Measures, *, chosen: bool = False
) -> list[AnyShape]:
    """Make the shapes of one place.

    Args:
        name: of the place.
        stand: pose of the lidar there.
        look: its row of a ranking; None: not ranked.
        measures: of the scenario.
        chosen: True if the look is recommended.
    """
    full = _HEIGHT * measures.reach
    radius = _RADIUS * measures.reach
    value = 0.0 if look is None else look.voa
    height = max(full * value, _DISC * measures.reach)
    colour = BLUE if chosen else SKY_BLUE if look is not None and look.ties_with_first else GREY
    label = _label(name, look, chosen=chosen)
    base: Vector = (stand.x, stand.y, 0.0)
    shapes: list[AnyShape] = [
        Cylinder(
            group="looks",
            name=name,
            label=label,
            position=(stand.x, stand.y, height / 2.0),
            radius=radius,
            height=height,
            colour=colour.faded(0.85),
        ),
        _heading(name, base, stand.yaw_rad, measures, colour),
        Text(
            group="looks",
            name=f"{name} name",
            text=name,
            position=(stand.x, stand.y, height + 0.06 * measures.reach),
            size=0.06 * measures.reach,
            colour=colour,
        ),
    ]
    error = None if look is None else look.standard_error
    if error:
        shapes += _error_bar(name, stand, full * value, full * 2.0 * error, radius)
    return shapes


def _heading(name: str, base: Vector, yaw: float, measures: Measures, colour: Colour) -> Polyline:
    """Line on the table from a place along the lidar's beam 0."""
    length = _ARROW * measures.reach
    return Polyline(
        group="looks",
        name=f"{name} heading",
        position=base,
        points=((0.0, 0.0, 0.002), (length * math.cos(yaw), length * math.sin(yaw), 0.002)),
        colour=colour,
    )


def _error_bar(name: str, stand: SensorPose, top: float, error: float, radius: float) -> list[AnyShape]:
    """Vertical line over two standard errors on both sides of a tower's top, with short ends."""
    low, high = max(top - error, 0.0), max(top + error, 0.0)
    ends = (
        ("error", ((0.0, 0.0, low), (0.0, 0.0, high))),
        ("upper error", ((-radius, 0.0, high), (radius, 0.0, high))),
        ("lower error", ((-radius, 0.0, low), (radius, 0.0, low))),
    )
    return [
        Polyline(
            group="looks", name=f"{name} {end}", position=(stand.x, stand.y, 0.0), points=points, colour=_ERROR_COLOUR
        )
        for end, points in ends
    ]


_ERROR_COLOUR = Colour(0.2, 0.2, 0.2)


def _label(name: str, look: RankedSensor | None, *, chosen: bool) -> str:
    """Write the name of a place with its VOA, its error, and how it compares with the best."""
    if look is None:
        return name
    error = "" if not look.standard_error else f" ± {look.standard_error:.3f}"
    rank = ", recommended" if chosen else f", {_ABOUT_EQUAL}" if look.ties_with_first else ""
    taken = "" if not look.looks_taken else f", looked from {look.looks_taken} times"
    return f"{name}: VOA {look.voa:+.3f}{error}{rank}{taken}"
