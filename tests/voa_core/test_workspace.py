import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from tests.support import twin
from voa_core.errors import InvalidInput
from voa_core.lidars import SensorConfiguration
from voa_core.workspace import Workspace

SQUARE = Workspace((-0.2, -0.2), (0.2, 0.2))


def test_beams_cross_the_box_where_they_should() -> None:
    sensor = SensorConfiguration("a", -1.0, 0.0, 0.0)
    crossing = SQUARE.crossing(sensor, np.array([0.0, math.pi, math.atan2(0.2, 0.9), math.pi / 2]))
    np.testing.assert_allclose(crossing.enter, [0.8, math.inf, math.hypot(0.8, 0.8 * 2 / 9), math.inf])
    np.testing.assert_allclose(crossing.leave, [1.2, -math.inf, math.hypot(0.9, 0.2), -math.inf])


def test_a_sensor_inside_is_in_the_box_from_the_start() -> None:
    crossing = SQUARE.crossing(SensorConfiguration("a", 0.1, 0.0, math.pi / 2), np.array([0.0, math.pi / 2]))
    np.testing.assert_allclose(crossing.enter, [0.0, 0.0])
    np.testing.assert_allclose(crossing.leave, [0.2, 0.3])


@pytest.mark.parametrize(("y", "crosses"), [(0.2, True), (-0.2, True), (0.2000001, False), (-0.3, False)])
def test_a_beam_along_a_wall_crosses_if_it_touches_the_box(y: float, crosses: bool) -> None:
    crossing = SQUARE.crossing(SensorConfiguration("a", -1.0, y, 0.0), np.array([0.0]))
    assert bool(np.isfinite(crossing.enter[0])) is crosses
    assert crossing.inside(np.array([1.0])).tolist() == [crosses]


def test_ranges_end_before_inside_or_beyond() -> None:
    crossing = SQUARE.crossing(SensorConfiguration("a", -1.0, 0.0, 0.0), np.zeros(5))
    ranges = np.array([0.5, 0.8, 1.0, 1.2, 1.3])
    assert crossing.before(ranges).tolist() == [True, False, False, False, False]
    assert crossing.inside(ranges).tolist() == [False, True, True, True, False]


@pytest.mark.parametrize(("off_m", "counts"), [(0.0, True), (9e-10, True), (1.1e-9, False), (1e-6, False)])
def test_a_range_that_misses_the_box_by_a_rounding_is_inside(off_m: float, counts: bool) -> None:
    # A side of the object may lie in the side of the box, and a prediction is exact to some 1e-16 m.
    crossing = SQUARE.crossing(SensorConfiguration("a", -1.0, 0.0, 0.0), np.zeros(2))
    ranges = np.array([0.8 - off_m, 1.2 + off_m])
    assert crossing.before(ranges).tolist() == [not counts, False]
    assert crossing.inside(ranges).tolist() == [counts, counts]


def test_nothing_ends_before_a_box_that_the_beam_never_enters() -> None:
    crossing = SQUARE.crossing(SensorConfiguration("a", -1.0, 0.0, math.pi), np.zeros(1))
    assert not crossing.before(np.array([0.5])).any()
    assert not crossing.inside(np.array([0.5])).any()


@settings(max_examples=60, deadline=None)
@given(seed=st.integers(0, 2**32 - 1))
def test_crossings_agree_with_the_twin(seed: int) -> None:
    rng = np.random.default_rng(seed)
    low = rng.uniform(-0.5, 0.2, 2)
    high = low + rng.uniform(0.05, 0.6, 2)
    x, y, yaw = (float(value) for value in rng.uniform(-1.0, 1.0, 3) * (1.0, 1.0, 4.0))
    angles = rng.uniform(-7.0, 7.0, 8)
    box = ((float(low[0]), float(low[1])), (float(high[0]), float(high[1])))
    crossing = Workspace(*box).crossing(SensorConfiguration("a", x, y, yaw), angles)
    for angle, enter, leave in zip(angles, crossing.enter, crossing.leave, strict=True):
        expected = twin.crossing(x, y, yaw + angle, box)
        assert (enter, leave) == pytest.approx((math.inf, -math.inf) if expected is None else expected, abs=1e-12)


@pytest.mark.parametrize(
    ("low", "high", "message"),
    [
        ((0.2, 0.0), (0.2, 1.0), "workspace: expected min below max in x and y"),
        ((0.0, 1.0), (1.0, 0.0), "workspace: expected min below max in x and y"),
        ((math.nan, 0.0), (1.0, 1.0), "workspace.min: expected finite numbers"),
        ((0.0, 0.0), (1.0, math.inf), "workspace.max: expected finite numbers"),
    ],
)
def test_a_box_that_is_none_is_refused(low: tuple[float, float], high: tuple[float, float], message: str) -> None:
    with pytest.raises(InvalidInput, match=message):
        Workspace(low, high)
