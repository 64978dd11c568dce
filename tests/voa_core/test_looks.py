import numpy as np
import pytest

from tests.voa_core.worlds import lidar_of
from voa_core.errors import InvalidInput
from voa_core.joint_weights import JointWeights
from voa_core.lidars import SensorConfiguration
from voa_core.looks import Driving, Looks, cost_of, exact_looks, same_configuration
from voa_core.prediction import Prediction
from voa_core.rules.registry import rule_of
from voa_core.weights import Weigher

HERE = SensorConfiguration("here", 0.0, 0.0, 0.0, cost=0.1)
THERE = SensorConfiguration("there", 3.0, 4.0, 0.0, cost=0.2)
LIDAR = lidar_of(1)
EXACT = exact_looks(
    lambda sensor: Weigher.of(
        rule_of("gaussian", LIDAR, sigma_m=0.5),
        Prediction.of_dense(LIDAR.grid, np.array([[0.5], [0.5 + 0.2 * (1.0 + sensor.x)]])),
        np.float64,
        keep=True,
    )
)
ALL = np.arange(2)


def test_weights_of_looks_multiply() -> None:
    here, there = (EXACT(sensor, 1).weights(ALL, ALL) for sensor in (HERE, THERE))
    together = Looks(EXACT).together(HERE, THERE)
    np.testing.assert_allclose(together.weights(ALL, ALL), here * there)
    np.testing.assert_allclose(Looks(EXACT).together(HERE, HERE).weights(ALL, ALL), here**2)
    assert isinstance(together, JointWeights)
    assert together.dtype == np.float64
    assert (together.matrix, together.panels, together.samples, together.simulated) == (None, None, 1, False)


def test_pending_looks_come_first_and_places_are_those_that_the_caller_joins() -> None:
    assert Looks(EXACT).baseline() is None
    looks = Looks(EXACT, (HERE, THERE), same_place=lambda _one, _other: True)
    baseline = looks.baseline()
    assert baseline is not None
    np.testing.assert_allclose(baseline.weights(ALL, ALL), EXACT(HERE, 1).weights(ALL, ALL) ** 2)


def test_a_configuration_is_one_whatever_its_cost() -> None:
    cheap = SensorConfiguration("here", 0.0, 0.0, 0.0)
    assert same_configuration(HERE, cheap)
    assert not same_configuration(HERE, THERE)
    assert not same_configuration(HERE, SensorConfiguration("here", 0.0, 0.0, 0.0, height_m=0.2))


def test_costs_of_looks_and_drives_by_hand() -> None:
    assert cost_of([HERE, THERE], None) == pytest.approx(0.3)
    driving = Driving(-1.0, 0.0, 0.01)
    assert cost_of([HERE], driving) == pytest.approx(0.1 + 0.01)
    assert cost_of([HERE, THERE], driving) == pytest.approx(0.3 + 0.01 + 0.05)


@pytest.mark.parametrize("wrong", [(np.nan, 0.0, 0.1), (0.0, np.inf, 0.1), (0.0, 0.0, -0.1)])
def test_drives_that_make_no_sense_are_refused(wrong: tuple[float, float, float]) -> None:
    with pytest.raises(InvalidInput):
        Driving(*wrong)
