"""Compare predicted beams with an independent ray caster, where a vertex of the object lies exactly on a beam.

    python -m tests.fuzz.beams --beams 1000000 --seed 1

Prisms of 3 to 64 sides are looked at from the bearing of every vertex, with the yaw written in every usual way, by
lidars that turn either way round, whose first beam points anywhere and whose grid may be more than a turn.
"""

import argparse
import math
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from voa_core.checks import Floats
from voa_core.lidars import BeamGrid, LidarModel, SensorConfiguration
from voa_core.objects import Object
from voa_core.poses import PoseSet
from voa_core.prediction import predictor_of_mesh

_HEIGHT_M = 0.5
_RANGE_MAX_M = 50.0
_TOLERANCE_M = 1e-8
_BRINK_RAD = 1e-9
"""Within this of a corner that is the edge of what is seen, or of a face seen edge on, a rounding decides."""


@dataclass
class Count:
    """Counts of one run: beams compared, those that hit, those on the brink, and the differences found."""

    beams: int = 0
    hits: int = 0
    brink: int = 0
    different: int = 0
    first_difference: str = ""


def compare(beams: int, seed: int) -> Count:
    """Compare at least so many beams; the same seed makes the same run."""
    rng = np.random.default_rng(seed)
    count = Count()
    while count.beams < beams:
        outline = _outline(rng)
        # One pose: the object's own frame is the world's, so that its coordinates stay as written.
        poses = PoseSet.from_arrays(["P"], [[0.0, 0.0, 0.0]], [[1.0, 0.0, 0.0, 0.0]])
        for sensor, grid in _looks(rng, outline):
            lidar = LidarModel(grid, 0.0, _RANGE_MAX_M, _HEIGHT_M, "missing", 0.01, 0.02, 0.05)
            predicted = predictor_of_mesh(_prism(outline), poses, lidar).predict(sensor).dense()[0]
            _tally(count, predicted, outline, sensor, grid)
            if count.beams >= beams:
                break
    return count


def _tally(count: Count, predicted: Floats, outline: Floats, sensor: SensorConfiguration, grid: BeamGrid) -> None:
    expected, brink = _cast(outline, sensor, grid)
    same = np.abs(np.minimum(predicted, 2.0 * _RANGE_MAX_M) - np.minimum(expected, 2.0 * _RANGE_MAX_M)) <= _TOLERANCE_M
    wrong = np.flatnonzero(~same & ~brink)
    count.beams += grid.beams
    count.hits += int(np.isfinite(expected).sum())
    count.brink += int(brink.sum())
    count.different += len(wrong)
    if len(wrong) and not count.first_difference:
        k = int(wrong[0])
        count.first_difference = (
            f"beam {k}: {predicted[k]!r}, expected {expected[k]!r}; {sensor}; {grid}; outline {outline.tolist()}"
        )


def _outline(rng: np.random.Generator) -> Floats:
    """Corners (n, 2) of a polygon that is star-shaped about its middle, counter-clockwise, in metres."""
    sides = int(rng.integers(3, 65))
    bearings = 2.0 * math.pi * np.arange(sides) / sides + rng.choice([0.0, math.pi / 4.0, rng.uniform(0.0, 6.0)])
    radii = rng.uniform(1.0, 2.0) * (np.ones(sides) if rng.random() < 0.5 else rng.uniform(0.6, 1.0, sides))
    corners = radii[:, None] * np.column_stack([np.cos(bearings), np.sin(bearings)])
    middle = rng.choice([0.0, 1.0, -3.0], 2) if rng.random() < 0.5 else rng.uniform(-2.0, 2.0, 2)
    placed: Floats = _on_a_lattice(corners) + np.round(middle) if rng.random() < 0.5 else corners + middle
    return placed


def _on_a_lattice(corners: Floats) -> Floats:
    """The polygon enlarged until no two corners meet, its corners on a lattice of eighths or of whole numbers."""
    lattice: Floats = np.round(corners * 4.0) if len(corners) <= 4 else np.round(corners * 2.0 * len(corners)) / 8.0
    return lattice


def _prism(outline: Floats) -> Object:
    """The outline as a prism from z = 0 to 1, closed above and below by fans about its middle."""
    n = len(outline)
    middle = outline.mean(axis=0)
    rings = [np.column_stack([np.vstack([outline, middle]), np.full(n + 1, z)]) for z in (0.0, 1.0)]
    faces = []
    for i in range(n):
        j = (i + 1) % n
        low, next_low, high, next_high = i, j, n + 1 + i, n + 1 + j
        faces += [[low, next_low, next_high], [low, next_high, high], [next_low, low, n], [high, next_high, 2 * n + 1]]
    return Object.from_arrays(np.vstack(rings), np.array(faces))


def _looks(rng: np.random.Generator, outline: Floats) -> Iterator[tuple[SensorConfiguration, BeamGrid]]:
    """Sensor poses from which a beam points exactly at a corner of the outline."""
    middle = outline.mean(axis=0)
    for corner in outline:
        away = corner - middle
        outward = math.atan2(away[1], away[0])
        reach = float(rng.choice([0.25, 1.0, 3.0, rng.uniform(0.1, 5.0)]))
        x, y = corner + reach * np.array([math.cos(outward), math.sin(outward)])
        tidy = rng.random() < 0.3
        if tidy:  # a sensor on the grid, which sees the corner under an angle of its own
            x, y = np.round(np.array([x, y]) + 2.0 * np.sign(away))
        inward = math.atan2(corner[1] - y, corner[0] - x) if tidy else outward
        turned = [inward, inward + 2.0 * math.pi, inward - 2.0 * math.pi]
        yaws = turned if tidy else [inward + math.pi, inward - math.pi, _normalised(inward + math.pi)]
        for yaw in yaws:
            for way in (1.0, -1.0):
                grid = _grid(rng, way)
                at = 0 if rng.random() < 0.5 else int(rng.integers(grid.beams))
                yield SensorConfiguration("s", float(x), float(y), float(yaw - grid.angles[at])), grid


def _grid(rng: np.random.Generator, way: float) -> BeamGrid:
    beams = int(rng.choice([1, 2, 7, 90, 360, 457, 720]))
    turns = float(rng.choice([1.0, 0.5, 2.5]))
    start = float(rng.choice([0.0, 0.0, -math.pi, math.pi, 2.0 * math.pi, rng.uniform(-7.0, 7.0)]))
    whole = bool(rng.random() < 0.8)  # else the last beam repeats the first
    spacing = min(2.0 * math.pi * turns / (beams if whole or beams == 1 else beams - 1), 2.0 * math.pi)
    return BeamGrid(beams, start, way * spacing)


def _normalised(angle: float) -> float:
    return math.remainder(angle, 2.0 * math.pi)


def _cast(outline: Floats, sensor: SensorConfiguration, grid: BeamGrid) -> tuple[Floats, NDArray[np.bool_]]:
    """Ranges of all beams, each against every side of the outline, and which of them are on the brink.

    A side is a closed set: a beam through a corner meets both sides that end there.
    """
    heading = sensor.yaw_rad + grid.angles
    along, across = np.cos(heading)[:, None], np.sin(heading)[:, None]
    x, y = outline[:, 0] - sensor.x, outline[:, 1] - sensor.y
    ahead, left = along * x + across * y, along * y - across * x  # of every corner, (r, n), in each beam's own frame
    next_ahead, next_left = np.roll(ahead, -1, axis=1), np.roll(left, -1, axis=1)
    slack = 1e-13 * (1.0 + np.hypot(x, y))
    meets = (left <= slack) & (next_left >= -slack) | (left >= -slack) & (next_left <= slack)
    apart = left - next_left
    share = np.clip(left / np.where(apart == 0.0, 1.0, apart), 0.0, 1.0)
    ranges = ahead + share * (next_ahead - ahead)
    ranges = np.where(meets & (ranges >= 0.0) & (ranges <= _RANGE_MAX_M), ranges, math.inf).min(axis=1)
    beam_passes = np.abs(left) <= _BRINK_RAD * np.hypot(x, y)
    sides = np.sign(np.where(beam_passes, 0.0, left))
    through = np.roll(sides, 1, axis=1) * np.roll(sides, -1, axis=1) < 0.0
    brink: NDArray[np.bool_] = np.logical_or.reduce(beam_passes & (ahead > 0.0) & ~through, axis=1)
    return ranges, brink


def main() -> int:
    """Run, print the counts, and return 1 if a beam differs."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--beams", type=int, default=1_000_000)
    parser.add_argument("--seed", type=int, default=1)
    options = parser.parse_args()
    count = compare(options.beams, options.seed)
    print(f"{count.beams} beams, {count.hits} hit; {count.brink} on the brink, left out; {count.different} differ")
    if count.different:
        print(count.first_difference)
    return 1 if count.different else 0


if __name__ == "__main__":
    raise SystemExit(main())
