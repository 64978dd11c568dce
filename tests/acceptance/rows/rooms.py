"""Presence and absence of a long object in cluttered rooms, by one scan of a lidar with beams of a quarter degree."""

import math
from functools import partial

import numpy as np

from tests.acceptance.customer import Service
from tests.acceptance.figures import Figure
from tests.acceptance.rooms import Room, fits, long_object, room, scan_of_room
from tests.acceptance.sizes import Size
from tests.acceptance.worlds import EXACT, World, displacements, stated
from voa_client import Scan, UncertainSensorPose, UpdatedEstimate, UpdateRequest

ABSENT = 0.9
_OBJECTS = 3
_NEAR_M, _NEAR_RAD = 0.05, math.radians(5.0)


def rows(service: Service, seed: int, size: Size) -> list[Figure]:
    """Count the rooms in which the object is recognised at its pose, and those in which its absence is."""
    sure: list[bool] = []
    right: list[bool] = []
    gone: list[bool] = []
    for index in range(_OBJECTS):
        world = long_object(seed + index)
        scenario = service.scenario_of(world, absent=ABSENT)
        numbers = range(index, size.rooms, _OBJECTS)
        present = [_with_object(world, np.random.default_rng([seed, 70, number])) for number in numbers]
        empty = [_without_object(np.random.default_rng([seed, 80, number])) for number in numbers]
        after = service.each(
            partial(_updated, service, scenario), [(cluttered, scan) for _, cluttered, scan in present]
        )
        sure += [_absent(each) < 0.5 for each in after]
        right += [_is_near(world, each, pose) for each, (pose, _, _) in zip(after, present, strict=True)]
        gone += [_absent(each) > 0.5 for each in service.each(partial(_updated, service, scenario), empty)]
    both = float(np.mean(np.array(sure) & np.array(right)))
    row, counts = "cluttered rooms, beams of 0.25 degrees, object 1.2 m long", f"{size.rooms} rooms, a scan each"
    more = f"present in {np.mean(sure):.3f}, likeliest pose right in {np.mean(right):.3f}"
    return [
        Figure(
            row,
            "present, and the likeliest pose within 5 cm and 5 degrees",
            both,
            "at least",
            0.95,
            f"{counts}; {more}",
        ),
        Figure(row, "absence recognised", float(np.mean(gone)), "at least", 0.95, counts),
    ]


def _without_object(rng: np.random.Generator) -> tuple[Room, Scan]:
    """Take a scan of a room without the object."""
    cluttered = room(rng)
    return cluttered, scan_of_room(cluttered, rng)


def _with_object(world: World, rng: np.random.Generator) -> tuple[int, Room, Scan]:
    """Put the object into a room where it stands free and is hardly hidden: its pose, the room, and a scan."""
    while True:
        cluttered, pose, moved = room(rng), int(rng.integers(len(world.poses))), displacements(1, rng)
        if fits(world, pose, cluttered, moved):
            break
    world.walls = cluttered.segments
    (scan,) = world.scans(pose, cluttered.place, moved, np.zeros((1, 3)), rng)
    return pose, cluttered, scan


def _updated(service: Service, scenario: str, taken: tuple[Room, Scan]) -> UpdatedEstimate:
    cluttered, scan = taken
    at = UncertainSensorPose.model_validate(stated(cluttered.place, EXACT).model_dump())
    return service.client.update_once(UpdateRequest(scenario=scenario, belief=None, sensor_pose=at, scan=scan))


def _absent(after: UpdatedEstimate) -> float:
    return -1.0 if after.absent is None else after.absent


def _is_near(world: World, after: UpdatedEstimate, pose: int) -> bool:
    """True if the likeliest pose is the listed one about which the object lies, or hardly differs from it."""
    likeliest, true = world.poses[int(np.argmax(after.belief))], world.poses[pose]
    away = math.dist(likeliest.position[:2], true.position[:2])
    turns = [2.0 * math.atan2(each.quaternion[3], each.quaternion[0]) for each in (likeliest, true)]
    return away <= _NEAR_M and abs(math.remainder(turns[0] - turns[1], 2.0 * math.pi)) <= _NEAR_RAD
