"""Cluttered rooms: walls, legs of furniture and boxes in the workspace, with a long object among them or without it."""

import math
from dataclasses import dataclass

import numpy as np

from tests.acceptance.casting import Floats, box, cast, turned
from tests.acceptance.shapes import angle_bar, quaternion
from tests.acceptance.worlds import Lidar, Noise, Place, Pose, World, scan_of
from voa_client import Scan

HEIGHT_M = 0.15
FINE = Lidar(None, 1440, -math.pi, math.radians(0.25), 10.0)
_NOISE = Noise(near_m=0.01, far_share=0.01, far_from_m=1.0, lost=0.02)
_CLEAR_M = 0.08
_HIDDEN = 0.25
_WIDE_M = 1.6
_NEAREST_M = 0.3


def long_object(seed: int) -> World:
    """Angle bar 1.2 m long, whose 24 poses are 4 positions with 6 yaws each; its one place has the lidar's height."""
    rng = np.random.default_rng([seed, 5])
    mesh = angle_bar(1.2, rng.uniform(0.35, 0.5), rng.uniform(0.08, 0.14), 0.3)
    poses = []
    for corner, middle in enumerate(((-0.25, -0.25), (-0.25, 0.25), (0.25, -0.25), (0.25, 0.25))):
        x, y = middle + rng.uniform(-0.1, 0.1, 2)
        first = rng.uniform(0.0, 2.0 * math.pi)
        for turn in range(6):
            name = f"{corner}-{turn}"
            poses.append(
                Pose(name, (round(float(x), 3), round(float(y), 3), 0.0), quaternion(first + math.pi * turn / 3))
            )
    scores = np.where(np.arange(4)[:, None] == np.arange(len(poses)) % 4, 0.9, 0.1)
    start = Place("start", -2.5, 0.0, 0.0, HEIGHT_M)
    return World(f"long-object-{seed}", mesh, poses, [start], scores, lidar=FINE, noise=_NOISE)


@dataclass(frozen=True, eq=False)
class Room:
    """A room: its segments (k, 2, 2), and where the lidar stands in it."""

    segments: Floats
    place: Place


def room(rng: np.random.Generator) -> Room:
    """Make a room: walls, sometimes a partition, two to four pieces of furniture with legs, and up to three boxes.

    Nothing stands closer to the lidar than 0.3 m.
    """
    while True:
        made = _any_room(rng)
        if float(_cast_from(made.segments, made.place).min()) > _NEAREST_M:
            return made


def _any_room(rng: np.random.Generator) -> Room:
    low = (-rng.uniform(2.8, 4.0), -rng.uniform(2.8, 4.0))
    high = (rng.uniform(0.7, 4.0), rng.uniform(0.7, 4.0))  # a wall may stand in the workspace
    parts = [box(low, high)]
    if rng.random() < 0.3:
        parts.append(_partition(rng))
    parts += [_legs(rng) for _ in range(rng.integers(2, 5))]
    for _ in range(rng.integers(0, 4)):
        size = rng.uniform(0.15, 0.6, 2)
        parts.append(_placed(box((-size[0] / 2, -size[1] / 2), (size[0] / 2, size[1] / 2)), _anywhere(rng), rng))
    bearing, distance = rng.uniform(math.pi, 1.5 * math.pi), rng.uniform(1.9, 2.6)
    place = Place("robot", distance * math.cos(bearing), distance * math.sin(bearing), rng.uniform(-3.0, 3.0), HEIGHT_M)
    return Room(np.concatenate(parts), place)


def scan_of_room(cluttered: Room, rng: np.random.Generator) -> Scan:
    """Take a scan of a room without the object."""
    ranges = _cast_from(cluttered.segments, cluttered.place)
    return scan_of(_NOISE.measure(np.where(ranges > FINE.range_max, np.inf, ranges), rng))


def fits(world: World, pose: int, cluttered: Room, moved: Floats) -> bool:
    """True if the object stands free in a room, and at most a quarter of its returns are hidden."""
    place, still = cluttered.place, np.zeros((1, 3))
    world.walls = np.zeros((0, 2, 2))
    alone = world.ranges(pose, place, moved, still)[0]
    around = _cast_from(cluttered.segments, place)
    returned = np.isfinite(alone)
    hidden = returned & (around < alone)
    outline = world.cuts[pose, HEIGHT_M].reshape(-1, 2) @ turned(float(moved[0, 2])).T
    outline = outline + np.array(world.poses[pose].position[:2]) + moved[0, :2]
    return (
        bool(returned.sum() >= 20)
        and bool(hidden.sum() <= _HIDDEN * returned.sum())
        and _apart(cluttered.segments, outline) > _CLEAR_M
    )


def _apart(segments: Floats, outline: Floats) -> float:
    """Smallest distance of points of the segments to points along an outline whose ends are given in pairs."""
    shares = np.linspace(0.0, 1.0, 41)[:, None, None]
    edges = outline.reshape(-1, 2, 2)
    along = (edges[:, 0] * (1.0 - shares) + edges[:, 1] * shares).reshape(-1, 2)
    around = (segments[:, 0] * (1.0 - shares) + segments[:, 1] * shares).reshape(-1, 2)
    return float(np.sqrt(((along[:, None, :] - around[None, :, :]) ** 2).sum(axis=2).min()))


def _cast_from(segments: Floats, place: Place) -> Floats:
    origin = np.array([[place.x, place.y]])
    ranges: Floats = cast(segments, origin, place.yaw_rad + FINE.angles[None, :])[0]
    return ranges


def _anywhere(rng: np.random.Generator) -> Floats:
    position: Floats = rng.uniform(-_WIDE_M, _WIDE_M, 2)
    return position


def _placed(segments: Floats, position: Floats, rng: np.random.Generator) -> Floats:
    placed: Floats = segments @ turned(rng.uniform(0.0, math.pi)).T + position
    return placed


def _partition(rng: np.random.Generator) -> Floats:
    length, thick = rng.uniform(1.5, 4.0), rng.uniform(0.02, 0.12)
    return _placed(box((-length / 2, -thick / 2), (length / 2, thick / 2)), _anywhere(rng), rng)


def _legs(rng: np.random.Generator) -> Floats:
    """Four round legs of a table or a chair."""
    width, depth, radius = rng.uniform(0.35, 1.2), rng.uniform(0.35, 0.8), rng.uniform(0.012, 0.035)
    bearings = 2.0 * math.pi * np.arange(9) / 8
    circle = radius * np.stack([np.cos(bearings), np.sin(bearings)], axis=1)
    leg = np.stack([circle[:-1], circle[1:]], axis=1)
    corners = [(x * width / 2, y * depth / 2) for x in (-1, 1) for y in (-1, 1)]
    return _placed(np.concatenate([leg + np.array(corner) for corner in corners]), _anywhere(rng), rng)
