"""The three shipped objects: a random look, three looks from one place, and three looks from the best places."""

import json
import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
import trimesh

import voa_assets
from tests.acceptance.casting import Floats
from tests.acceptance.customer import Service, grasp_index, scan_request
from tests.acceptance.figures import Figure
from tests.acceptance.looks import Looks, counts_of, covered, looks_at
from tests.acceptance.rows.designed import uniform
from tests.acceptance.sizes import Size
from tests.acceptance.values import success
from tests.acceptance.worlds import EXACT, Place, Pose, World, displacements, errors
from voa_client import PoseUncertainty, SessionRequest, VoaRequest

OBJECTS = ("mug", "mallet", "block")
CENTIMETRE = PoseUncertainty(xy_m=0.01, yaw_rad=math.radians(1.0))
ROBOTS = {
    "exact": EXACT,
    "1 cm, 1 degree": CENTIMETRE,
    "3 cm, 2 degrees": PoseUncertainty(xy_m=0.03, yaw_rad=math.radians(2.0)),
}
GAINS = {"exact": 0.38, "1 cm, 1 degree": 0.35, "3 cm, 2 degrees": 0.25}
_LOOKS = 3


@dataclass(frozen=True, eq=False)
class Stored:
    """A shipped object: its world, and the id of its scenario."""

    world: World
    scenario: str


def random_look_rows(service: Service, seed: int, size: Size) -> list[Figure]:
    """Measure the gain of a random look at the mug, the mallet and the block, under the default rule."""
    stored = [_stored(service, name) for name in OBJECTS]
    looks = {robot: _every_look(service, stored, robot, seed, size) for robot in ROBOTS}
    figures = [_random_look(robot, each) for robot, each in looks.items()]
    return [*figures, covered("shipped objects, all robots", [look for each in looks.values() for look in each])]


def three_looks_rows(service: Service, seed: int, size: Size) -> list[Figure]:
    """Measure promised less achieved success after three looks from one place."""
    stored = [_stored(service, name) for name in OBJECTS]
    return [_three_looks(service, stored, robot, seed, size) for robot in ("exact", "1 cm, 1 degree")]


def shipped(name: str) -> tuple[World, dict[str, Any]]:
    """Make the world of a shipped object, and the fields of its scenario that the world does not have."""
    folder = voa_assets.path(name)
    body = json.loads((folder / "scenario.json").read_text(encoding="utf-8"))
    height = body["lidar"]["height_m"]
    scores = np.array(body["scores"]["successes"]) / body["scores"]["attempts"]
    world = World(
        name,
        trimesh.load_mesh(folder / body["object"], process=False),
        [Pose(pose["name"], tuple(pose["position"]), tuple(pose["quaternion_wxyz"])) for pose in body["poses"]],
        [Place(each["name"], each["x"], each["y"], each["yaw_rad"], height) for each in body["sensors"]],
        scores,
    )
    return world, {"scores": body["scores"], "workspace": body["workspace"]}


def _stored(service: Service, name: str) -> Stored:
    world, fields = shipped(name)
    return Stored(world, service.scenario_of(world, **fields))


def _every_look(service: Service, stored: list[Stored], robot: str, seed: int, size: Size) -> list[Looks]:
    """Value all looks at each object under the uniform belief."""
    scans, number = max(2, size.scans // 2), list(ROBOTS).index(robot)
    return [
        looks_at(
            service,
            each.world,
            each.scenario,
            uniform(each.world),
            scans,
            np.random.default_rng([seed, 50, index, number]),
            ROBOTS[robot],
        )
        for index, each in enumerate(stored)
    ]


def _random_look(robot: str, looks: list[Looks]) -> Figure:
    """Mean true value of all looks at all objects."""
    gains = [float(each.values.true.mean()) for each in looks]
    by_object = ", ".join(f"{name} {gain:.3f}" for name, gain in zip(OBJECTS, gains, strict=True))
    counts = f"{counts_of(looks)}; {by_object}"
    row, gain = f"shipped objects, robot {robot}", float(np.mean(gains))
    return Figure(row, "gain of a random look", gain, "at least", GAINS[robot], counts)


@dataclass(frozen=True)
class End:
    """End of a session: expected score of the best grasp, its true success probability, and the number of places."""

    promised: float
    achieved: float
    places: int


Choose = Callable[[str, int], Place]
"""A function that chooses the place of the next look, from the id of a session and the number of looks before."""


def _sessions(
    service: Service,
    stored: list[Stored],
    std: PoseUncertainty,
    choose: Callable[[Stored], Choose],
    seed: int,
    size: Size,
) -> list[End]:
    """Run sessions of three looks at each object, equally many near each pose; a robot errs once for each place."""
    ends: list[End] = []
    for index, each in enumerate(stored):
        choice = choose(each)

        def run(number: int, each: Stored = each, choice: Choose = choice, index: int = index) -> End:
            rng = np.random.default_rng([seed, 60, index, number])
            pose = number % len(each.world.poses)
            return _session(service, each, pose, std, choice, rng)

        ends += service.each(run, range(size.sessions))
    return ends


def _session(
    service: Service, stored: Stored, pose: int, std: PoseUncertainty, choose: Choose, rng: np.random.Generator
) -> End:
    client, world = service.client, stored.world
    session = client.create_session(SessionRequest(scenario=stored.scenario)).id
    moved = displacements(1, rng)
    strayed: dict[str, Floats] = {place.name: errors(1, std, rng) for place in world.places}
    taken = set()
    for look in range(_LOOKS):
        place = choose(session, look)
        taken.add(place.name)
        (scan,) = world.scans(pose, place, moved, strayed[place.name], rng)
        after = client.apply_scan(session, scan_request(place, scan, std))
    client.delete_session(session)
    return End(after.expected_score, success(world, grasp_index(after.best_grasp), pose), len(taken))


def _three_looks(service: Service, stored: list[Stored], robot: str, seed: int, size: Size) -> Figure:
    """Promised less achieved after three looks from one place: the first of the ranking."""
    std = ROBOTS[robot]

    def choose(each: Stored) -> Choose:
        ranking = service.rank(each.scenario, uniform(each.world), std)
        (place,) = [place for place in each.world.places if place.name == ranking.ranking[0].sensor]
        return lambda _session, _look: place

    ends = _sessions(service, stored, std, choose, seed, size)
    return _difference(f"three looks from one place, robot {robot}", ends)


def greedy_rows(service: Service, seed: int, size: Size) -> list[Figure]:
    """Measure what is achieved, and promised, where each of three looks is the first of the session's ranking."""
    stored = [_stored(service, name) for name in OBJECTS]

    def choose(each: Stored) -> Choose:
        by_name = {place.name: place for place in each.world.places}
        request = VoaRequest(sensor_std=CENTIMETRE)
        return lambda session, _look: by_name[service.client.rank_looks(session, request).ranking[0].sensor]

    ends = _sessions(service, stored, CENTIMETRE, choose, seed, size)
    row = "greedy, three looks, robot 1 cm, 1 degree"
    achieved = float(np.mean([end.achieved for end in ends]))
    counts = f"{len(ends)} sessions, {np.mean([end.places for end in ends]):.2f} places each"
    return [Figure(row, "achieved", achieved, "at least", 0.85, counts), _difference(row, ends)]


def _difference(row: str, ends: list[End]) -> Figure:
    promised, achieved = (np.array([getattr(end, name) for end in ends]) for name in ("promised", "achieved"))
    off = promised - achieved
    counts = f"{len(ends)} sessions: {promised.mean():.3f} promised, {achieved.mean():.3f} achieved; "
    counts += f"standard error {off.std() / math.sqrt(len(off)):.3f}"
    return Figure(row, "promised less achieved", float(off.mean()), "within", 0.03, counts)
