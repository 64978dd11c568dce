"""Scenes designed to separate ways of choosing a look: poses against grasps, worthless places, exclusive or."""

import math
from dataclasses import dataclass

import numpy as np

from tests.acceptance.customer import Service, grasp_index, scan_request
from tests.acceptance.figures import Figure
from tests.acceptance.scenes import exclusive_or, poses_against_grasps, worthless_nearby
from tests.acceptance.sizes import Size
from tests.acceptance.values import promised, success, true_values
from tests.acceptance.worlds import EXACT, World, displacements, errors
from voa_client import GraspNow, PoseUncertainty, SessionRequest, VoaRequest

LARGE = PoseUncertainty(xy_m=0.03, yaw_rad=math.radians(2.0))
_MOST_LOOKS = 4


def uniform(world: World) -> np.ndarray:
    """Uniform belief over a world's poses."""
    return np.full(len(world.poses), 1.0 / len(world.poses))


def poses_against_grasps_rows(service: Service, seed: int, size: Size) -> list[Figure]:
    """Gain of the look that VOA ranks first, and of the one after which the entropy is lowest."""
    right, gains, by_entropy, scans = [], [], [], 0
    for index in range(size.rankings):
        world = poses_against_grasps(seed + index)
        scenario = service.scenario_of(world)
        ranking = service.rank(scenario, uniform(world))
        right.append(ranking.ranking[0].sensor.startswith("grasp-"))
        if index >= size.scenes:
            continue
        rng = np.random.default_rng([seed + index, 20])
        values = true_values(service, world, scenario, uniform(world), size.scans, rng)
        scans += values.gains.size
        best = [place.name for place in world.places].index(ranking.ranking[0].sensor)
        gains.append(values.true[best])
        surest = int(np.argmin(values.entropies.mean(axis=2) @ values.belief))
        by_entropy.append(values.true[surest])
    row, counts = "poses against grasps", f"{len(gains)} seeds, {scans} scans"
    entropy = f"{counts}; gain of the look with the lowest entropy {np.mean(by_entropy):.3f}"
    return [
        Figure(row, "gain of VOA's choice", float(np.mean(gains)), "at least", 0.4, entropy),
        Figure(
            row,
            "share of seeds with the right kind of look",
            float(np.mean(right)),
            "at least",
            0.95,
            f"{len(right)} seeds",
        ),
    ]


def worthless_nearby_rows(service: Service, seed: int, size: Size) -> list[Figure]:
    """Gain of the first of the ranking for a robot that errs by 3 cm and 2 degrees, and what was promised of it."""
    gains, promises, near, exact, kinds, scans = [], [], [], [], [], 0
    for index in range(size.rankings):
        world = worthless_nearby(seed + index)
        scenario = service.scenario_of(world)
        ranking = service.rank(scenario, uniform(world), LARGE)
        kinds.append(ranking.ranking[0].sensor.startswith("far-"))
        if index >= size.scenes:
            continue
        rng = np.random.default_rng([seed + index, 30])
        values = true_values(service, world, scenario, uniform(world), size.scans, rng, LARGE)
        scans += values.gains.size
        names = [place.name for place in world.places]
        best = names.index(ranking.ranking[0].sensor)
        gains.append(values.true[best])
        promises.append(ranking.ranking[0].voa)
        nearby = [place for place, name in enumerate(names) if name.startswith("near-")]
        near.append(values.true[nearby].mean())
        exact.append(promised(service.rank(scenario, uniform(world)), world.places)[0][nearby].mean())
    row, counts = "nearest places worthless at 3 cm, 2 degrees", f"{len(gains)} seeds, {scans} scans"
    more = f"near places gain {np.mean(near):.3f} (promised to an exact robot: {np.mean(exact):.3f}); "
    more += f"a far place first in {np.mean(kinds):.2f} of {len(kinds)} seeds"
    off = float(np.mean(promises) - np.mean(gains))
    return [
        Figure(row, "gain of VOA's choice", float(np.mean(gains)), "at least", 0.3, f"{counts}; {more}"),
        Figure(row, "promised less achieved", off, "within", 0.05, counts),
    ]


@dataclass(frozen=True)
class Outcome:
    """Result of a session that follows recommendations: success less costs, and number of looks."""

    net: float
    looks: int


def exclusive_or_rows(service: Service, seed: int, size: Size) -> list[Figure]:
    """Follow the recommendations where two looks are worth nothing alone, at a cost of 0.03 and of 0.25 each."""
    row, figures = "two looks worth nothing alone", []
    cheap: list[Outcome] = []
    for index in range(size.scenes):
        cheap += _followed(service, exclusive_or(seed + index, 0.03), size.scans, seed + index)
    counts = f"{len(cheap)} sessions on {size.scenes} seeds, {np.mean([each.looks for each in cheap]):.2f} looks each"
    net = float(np.mean([each.net for each in cheap]))
    figures.append(Figure(row, "success less costs of 0.03 a look", net, "at least", 0.8, counts))
    first = []
    for index in range(size.rankings):
        world = exclusive_or(seed + index, 0.25)
        ranking = service.rank(service.scenario_of(world), uniform(world))
        first.append(isinstance(ranking.recommendation, GraspNow))
    at_once = float(np.mean(first))
    return [
        *figures,
        Figure(
            row, "share of seeds that grasp at once at 0.25 a look", at_once, "at least", 1.0, f"{len(first)} seeds"
        ),
    ]


def _followed(service: Service, world: World, scans: int, seed: int) -> list[Outcome]:
    """Run sessions that look as recommended until a grasp is: an equal number at each pose."""
    scenario = service.scenario_of(world)
    poses = [pose for pose in range(len(world.poses)) for _ in range(max(1, scans // 2))]

    def run(session: int) -> Outcome:
        return _follow(service, world, scenario, poses[session], np.random.default_rng([seed, 40, session]))

    return service.each(run, range(len(poses)))


def _follow(service: Service, world: World, scenario: str, pose: int, rng: np.random.Generator) -> Outcome:
    client, by_name = service.client, {place.name: place for place in world.places}
    session = client.create_session(SessionRequest(scenario=scenario))
    moved, costs, looks, planned = displacements(1, rng), 0.0, 0, None
    strayed = {name: errors(1, EXACT, rng) for name in by_name}
    while looks < _MOST_LOOKS:
        name = planned
        if name is None:
            advice = client.rank_looks(session.id, VoaRequest()).recommendation
            if isinstance(advice, GraspNow):
                break
            name, planned = advice.sensor, advice.then
        else:
            planned = None
        place = by_name[name]
        (scan,) = world.scans(pose, place, moved, strayed[name], rng)
        client.apply_scan(session.id, scan_request(place, scan, EXACT))
        costs, looks = costs + place.cost, looks + 1
    grasp = grasp_index(client.get_session(session.id).best_grasp)
    client.delete_session(session.id)
    return Outcome(success(world, grasp, pose) - costs, looks)
