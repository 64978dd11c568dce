"""Map of the VOA around the table: a grid of sensor poses that look at the middle of the poses, and its tiles."""

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass

from voa_msgs.geometry import CandidateSensor
from voa_msgs.rankings import RankedSensor
from voa_msgs.scenarios import Scenario
from voa_scene.measures import measures_of
from voa_scene.shapes import AnyShape, Box, Colour

CHUNK = 24
"""Most places in one request, so that progress is seen and a cancellation takes effect soon."""
_ACROSS = 17
"""Number of tiles along each edge of the map."""
_REACH = 1.15
"""Half an edge of the map, as a share of the distance to the farthest place."""
_CLEAR = 0.35
"""Distance from the middle within which no lidar stands if there is no workspace, as a share of the reach."""
_CLEARANCE_M = 0.1
_THICKNESS_M = 0.0005
_STOPS = ("#00224e", "#35456c", "#666970", "#948e77", "#c8b866", "#fee838")
"""Colours of the map from the least to the largest VOA: blue to yellow, ever lighter, for every eye."""


@dataclass(frozen=True)
class Tile:
    """Tile of the map.

    Attributes:
        sensor: place of the lidar at the middle of the tile.
        edge: of the tile, metres.
        look: its row of a ranking; None: not valued yet.
    """

    sensor: CandidateSensor
    edge: float
    look: RankedSensor | None = None


def grid(scenario: Scenario, across: int = _ACROSS) -> list[Tile]:
    """Lay out tiles around the middle of the poses, row by row, without those where the object lies.

    Each place looks at the middle of the poses.

    Args:
        scenario: with its poses, places and workspace.
        across: number of tiles along each edge.
    """
    measures = measures_of(scenario)
    (x0, y0), half = measures.middle, _REACH * measures.reach
    edge = 2.0 * half / across
    tiles = []
    for row in range(across):
        for column in range(across):
            x, y = x0 - half + (column + 0.5) * edge, y0 - half + (row + 0.5) * edge
            if _is_free(scenario, x, y, measures.middle, measures.reach):
                yaw = facing(x, y, measures.middle)
                sensor = CandidateSensor(name=f"tile {row}, {column}", x=round(x, 4), y=round(y, 4), yaw_rad=yaw)
                tiles.append(Tile(sensor, edge))
    return tiles


def facing(x: float, y: float, towards: tuple[float, float]) -> float:
    """Return the yaw of a lidar at x, y whose beam 0 points at `towards`, radians."""
    return math.atan2(towards[1] - y, towards[0] - x)


def _is_free(scenario: Scenario, x: float, y: float, middle: tuple[float, float], reach: float) -> bool:
    """True if a lidar can stand at x, y: outside of the workspace, or away from the middle if there is none."""
    space = scenario.workspace
    if space is None:
        return math.dist((x, y), middle) > _CLEAR * reach
    inside = all(
        low - _CLEARANCE_M < part < high + _CLEARANCE_M
        for low, part, high in zip(space.min, (x, y), space.max, strict=True)
    )
    return not inside


def chunks(tiles: Sequence[Tile], size: int = CHUNK) -> Iterator[Sequence[Tile]]:
    """Yield the tiles in groups of at most `size`."""
    for start in range(0, len(tiles), size):
        yield tiles[start : start + size]


def valued(tiles: Sequence[Tile], ranking: Sequence[RankedSensor]) -> list[Tile]:
    """Return the tiles with their rows of a ranking of them, matched by name."""
    by_name = {look.sensor: look for look in ranking}
    return [Tile(tile.sensor, tile.edge, by_name.get(tile.sensor.name or "")) for tile in tiles]


def limits(tiles: Sequence[Tile]) -> tuple[float, float]:
    """Return the VOA of the darkest and of the lightest colour: 0 or the least, and the largest."""
    values = [tile.look.voa for tile in tiles if tile.look is not None]
    return min([0.0, *values]), max([1e-3, *values])


def tile_shapes(tiles: Sequence[Tile]) -> list[AnyShape]:
    """Make flat boxes of the tiles that have a value, the lighter the larger the VOA."""
    least, most = limits(tiles)
    return [
        Box(
            group="looks",
            name=f"map {tile.sensor.name}",
            label=f"x {tile.sensor.x:.2f} m, y {tile.sensor.y:.2f} m: VOA {tile.look.voa:+.3f}",
            position=(tile.sensor.x, tile.sensor.y, _THICKNESS_M / 2.0),
            size=(0.96 * tile.edge, 0.96 * tile.edge, _THICKNESS_M),
            colour=colour_at((tile.look.voa - least) / (most - least)),
        )
        for tile in tiles
        if tile.look is not None
    ]


def colour_at(share: float) -> Colour:
    """Return the colour of a value between the least (0) and the largest (1)."""
    position = min(max(share, 0.0), 1.0) * (len(_STOPS) - 1)
    index = min(int(position), len(_STOPS) - 2)
    low, high = _parts(_STOPS[index]), _parts(_STOPS[index + 1])
    weight = position - index
    red, green, blue = (round(a + weight * (b - a), 4) for a, b in zip(low, high, strict=True))
    return Colour(red, green, blue)


def gradient() -> str:
    """Return the colours as a CSS gradient from left to right, for the legend."""
    return f"linear-gradient(to right, {', '.join(_STOPS)})"


def _parts(code: str) -> tuple[float, ...]:
    return tuple(int(code[start : start + 2], 16) / 255.0 for start in (1, 3, 5))
