"""The world of the table: its ray casting agrees with the service's predictions, and its noise is as stated."""

import math
from collections.abc import Iterator

import numpy as np
import pytest

from tests.acceptance.casting import box, cast
from tests.acceptance.customer import Service, service
from tests.acceptance.rows.shipped import shipped
from tests.acceptance.scenes import exclusive_or, finned, poses_against_grasps, worthless_nearby
from tests.acceptance.worlds import Noise, World, scan_of


@pytest.fixture(scope="module")
def running() -> Iterator[Service]:
    with service() as started:
        yield started


@pytest.mark.parametrize(
    "world",
    [finned(5), poses_against_grasps(5), worthless_nearby(5), exclusive_or(5, 0.03), shipped("mug")[0]],
    ids=lambda world: world.name,
)
def test_ray_casting_agrees_with_the_predictions_of_the_service(running: Service, world: World) -> None:
    predictions = running.client.predict(running.scenario_of(world))
    world.walls = np.zeros((0, 2, 2))
    still = np.zeros((1, 3))
    for sensor, place in enumerate(world.places):
        for pose in range(len(world.poses)):
            own = world.ranges(pose, place, still, still)[0]
            theirs = np.array([math.inf if each is None else each for each in predictions.ranges[sensor][pose]])
            assert np.isfinite(own).sum() >= 3
            # A beam that touches an edge may go either way.
            assert (np.isfinite(own) != np.isfinite(theirs)).sum() <= 1
            both = np.isfinite(own) & np.isfinite(theirs)
            np.testing.assert_allclose(own[both], theirs[both], atol=1e-6)


def test_a_ray_meets_the_nearest_segment() -> None:
    ranges = cast(box((1.0, -1.0), (2.0, 1.0)), np.zeros((1, 2)), np.array([[0.0, math.pi, math.atan2(0.5, 1.0)]]))
    np.testing.assert_allclose(ranges, [[1.0, math.inf, math.hypot(1.0, 0.5)]])


def test_a_displaced_object_is_seen_from_a_robot_that_errs_by_as_much() -> None:
    world = finned(6)
    world.walls = np.zeros((0, 2, 2))
    moved = np.array([[0.01, -0.02, 0.0]])
    place = world.places[0]
    both = world.ranges(0, place, moved, moved)
    np.testing.assert_allclose(both, world.ranges(0, place, np.zeros((1, 3)), np.zeros((1, 3))), atol=1e-9)


def test_the_noise_is_that_of_the_table() -> None:
    rng, noise = np.random.default_rng(1), Noise()
    near, far = (noise.measure(np.full(20_000, true), rng) for true in (0.3, 1.0))
    assert np.nanstd(near) == pytest.approx(0.003, rel=0.05)
    assert np.nanstd(far) == pytest.approx(0.03, rel=0.05)
    assert np.isnan(near).mean() == pytest.approx(0.04, abs=0.01)
    scan = scan_of(np.array([0.5, np.nan, np.inf]))
    assert (scan.ranges, scan.no_return) == ([0.5, None, None], [2])
