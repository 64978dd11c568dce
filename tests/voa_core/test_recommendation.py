from dataclasses import replace
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from tests.voa_core.worlds import lidar_of
from voa_core import recommendation
from voa_core.assistance import Assistance, Definition, Valuation
from voa_core.filtering import Belief
from voa_core.grasps import Choice, GraspTable
from voa_core.lidars import SensorConfiguration
from voa_core.looks import Driving, Looks, exact_looks
from voa_core.poses import PoseSet
from voa_core.prediction import ObservationPredictor
from voa_core.ranking import RankedLook, Ranking, rank_looks
from voa_core.recommendation import Recommendation, recommend
from voa_core.rules.registry import rule_of
from voa_core.scan_model import ScanModel
from voa_core.simulated_weights import simulated_looks
from voa_core.simulation import Sampling, samples_per_pose
from voa_core.updating import UpdatePolicy
from voa_core.weights import Weigher

LIDAR = lidar_of(1, range_max=2.0)
BITS = [(0, 0), (0, 1), (1, 0), (1, 1)]
"""Two features of four poses, each shown by a place of its own. The grasp depends on their exclusive or."""
RANGES = {"first": [[0.5 + first] for first, _ in BITS], "second": [[0.5 + second] for _, second in BITS]}
RANGES["blind"] = [[0.7]] * 4
RANGES["both"] = [[0.4], [0.7], [1.0], [1.3]]
TABLE = GraspTable.of_probabilities(["equal", "different"], [[0.9, 0.0, 0.0, 0.9], [0.0, 0.9, 0.9, 0.0]], 4)
VALUATION = Valuation(Belief.uniform(4), TABLE, UpdatePolicy(), "executed")
MODEL = ScanModel(
    ObservationPredictor(
        PoseSet.named(["00", "01", "10", "11"]), LIDAR, {name: np.array(ranges) for name, ranges in RANGES.items()}
    ),
    rule_of("beam", LIDAR),
    UpdatePolicy(),
    "exclusive or",
)
SAMPLING = Sampling(MODEL.seed, samples_per_pose(4))


def place(name: str, cost: float = 0.03, x: float = 0.0) -> SensorConfiguration:
    return SensorConfiguration(name, x, 0.0, 0.0, cost=cost)


def simulated(sampling: Sampling, **settings: Any) -> Looks:
    of = simulated_looks(MODEL, sampling, lists=lambda _sensor: True, log_sums_of=lambda _sensor: None)
    return Looks(of, **settings)


def exact(**settings: Any) -> Looks:
    def weigher(sensor: SensorConfiguration) -> Weigher:
        return Weigher.of(MODEL.rule, MODEL.predictor.predict(sensor, listed=True), np.float64, keep=True)

    return Looks(exact_looks(weigher), **settings)


def ranked(looks: Looks, *places: SensorConfiguration, driving: Driving | None = None) -> Ranking:
    return rank_looks(places, looks, VALUATION, driving=driving)


def advice(
    *places: SensorConfiguration, on_simulated: bool = True, pending: tuple[str, ...] = (), **settings: Any
) -> Recommendation:
    waiting = tuple(place(name) for name in pending)
    looks = simulated(SAMPLING, pending=waiting) if on_simulated else exact(pending=waiting)
    fresh = simulated(SAMPLING.fresh(), pending=waiting) if on_simulated else None
    ranking = ranked(looks, *places, driving=settings.get("driving"))
    return recommend(ranking, looks, VALUATION, fresh=fresh, **settings)


def names(done: Recommendation) -> list[str | None]:
    return [None if look is None else look.sensor.name for look in (done.look, done.then)]


@pytest.mark.parametrize("on_simulated", [True, False])
def test_two_looks_that_are_worth_nothing_alone_are_recommended_together(on_simulated: bool) -> None:
    done = advice(place("first"), place("blind"), place("second", 0.02), on_simulated=on_simulated)
    assert names(done) == ["second", "first"]
    assert done.lookahead == 2
    assert done.net_value == pytest.approx(0.45 - 0.05, abs=0.02)
    assert all(abs(look.assistance.voa) < 0.05 for look in done.ranking.looks)
    assert (done.standard_error is not None) is on_simulated


@pytest.mark.parametrize("on_simulated", [True, False])
@pytest.mark.parametrize(("costs", "lookahead"), [((0.25, 0.25), 2), ((0.03, 0.44), 2), ((0.03, 0.03), 1)])
def test_a_grasp_is_recommended_where_two_looks_cost_too_much(
    on_simulated: bool, costs: tuple[float, float], lookahead: int
) -> None:
    done = advice(place("first", costs[0]), place("second", costs[1]), on_simulated=on_simulated, lookahead=lookahead)
    assert names(done) == [None, None]
    assert (done.net_value, done.standard_error, done.lookahead) == (None, None, lookahead)


def test_a_single_look_that_is_enough_goes_before_a_pair() -> None:
    done = advice(place("first"), place("second"), place("both"))
    assert names(done) == ["both", None]
    assert done.net_value == pytest.approx(0.45 - 0.03, abs=0.02)


def test_the_best_look_has_values_of_its_own_over_four_times_as_many_scans() -> None:
    done = advice(place("first"), place("both"), place("second"))
    first = done.ranking.looks[0]
    assert first.sensor.name == "both"
    assert first.assistance.gains.shape == (4, 4 * 64)
    assert done.ranking.looks[1].assistance.gains.shape == (4, 64)
    assert done.ranking.compared[0].sensor.name == "both"
    assert done.ranking.compared[0].assistance.gains.shape == (4, 64)
    assert [done.ranking.ties_with_first(look) for look in done.ranking.looks] == [True, False, False]
    again = advice(place("first"), place("both"), place("second"))
    assert again.ranking.looks[0].assistance.voa == first.assistance.voa


def test_a_look_that_was_first_by_luck_leaves_its_place_to_the_next() -> None:
    lucky, steady, last = (place(name) for name in ("lucky", "steady", "last"))
    shared = {"lucky": 0.3, "steady": 0.2, "last": 0.1}
    own = {"lucky": 0.15, "steady": 0.19, "last": 0.0}
    ranking = Ranking.of(Choice(0, 0.5), [look_of(each, shared[each.name]) for each in (lucky, steady, last)], 0.4)
    assert [look.sensor.name for look in ranking.looks] == ["lucky", "steady", "last"]
    for each in (lucky, steady):
        ranking = ranking.with_value(ranking.looks[0], look_of(each, own[each.name]))
    assert [(look.sensor.name, look.net_value) for look in ranking.looks] == [
        ("steady", 0.19),
        ("lucky", 0.15),
        ("last", 0.1),
    ]
    assert [look.net_value for look in ranking.compared] == [0.2, 0.3, 0.1]
    assert [ranking.ties_with_first(look) for look in ranking.looks] == [True, True, False]
    moved = ranking.with_first(ranking.looks[2])
    assert [look.sensor.name for look in moved.looks] == ["last", "steady", "lucky"]


def test_of_many_equal_looks_few_are_evaluated_and_the_best_of_these_goes_first(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr(recommendation, "_MOST_EVALUATED", 2)
    done = advice(*(place("both", cost) for cost in (0.03, 0.0300001, 0.0300002)))
    sizes = [look.assistance.gains.shape[1] for look in done.ranking.looks]
    assert sizes[0] == 4 * 64
    assert sorted(sizes) in ([64, 64, 256], [64, 256, 256])


def look_of(sensor: SensorConfiguration, value: float) -> RankedLook:
    """A look whose value has no error."""
    nothing = np.zeros(1)
    gains = np.full((1, 2), value)
    assistance = Assistance(value, value, np.array([0]), np.array([0]), nothing, np.ones(1), gains, 0.0)
    return RankedLook(sensor, assistance, value, 0.0)


def test_one_place_or_more_than_64_make_no_pairs(monkeypatch: pytest.MonkeyPatch) -> None:
    assert advice(place("first")).lookahead == 1
    many = [SensorConfiguration("first", 0.0, 0.0, 0.0, cost=0.03)] * 65
    assert advice(*many, on_simulated=False).lookahead == 1
    monkeypatch.setattr(recommendation, "_MOST_PAIR_BYTES", 100)
    assert names(advice(place("first"), place("second"))) == [None, None]


@pytest.mark.parametrize(("definition", "pairs"), [("executed", 0), ("posterior", 1)])
def test_pairs_that_cannot_gain_enough_are_not_evaluated(
    definition: Definition, pairs: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    """No executed value exceeds that of perfect information, 0.45 here, and the looks cost 0.06."""
    evaluated = []

    def valued(*pair: object) -> SimpleNamespace:
        evaluated.append(pair)
        return SimpleNamespace(net_value=0.0, sure_net_value=0.0)

    monkeypatch.setattr(recommendation, "_valued", valued)
    looks, valuation = exact(), replace(VALUATION, definition=definition)
    ranking = rank_looks([place("first"), place("second")], looks, valuation)
    assert names(recommend(ranking, looks, valuation, min_gain=0.4)) == [None, None]
    assert len(evaluated) == pairs


def test_a_gain_must_exceed_what_is_demanded() -> None:
    assert names(advice(place("both"), min_gain=0.5)) == [None, None]
    assert names(advice(place("first"), place("second"), min_gain=0.35)) == ["first", "second"]
    assert names(advice(place("first"), place("second"), min_gain=0.42)) == [None, None]


def test_a_drive_is_paid_from_place_to_place() -> None:
    driving = Driving(-1.0, 0.0, 0.1)
    near, far = place("first", 0.01, x=0.0), place("second", 0.01, x=1.0)
    done = advice(near, far, on_simulated=False, driving=driving)
    assert [look.cost for look in done.ranking.looks] == pytest.approx([0.11, 0.21])
    assert names(done) == ["first", "second"]
    assert done.net_value == pytest.approx(0.45 - 0.02 - 0.1 - 0.1)
    assert names(advice(near, far, on_simulated=False, driving=Driving(-1.0, 0.0, 0.3))) == [None, None]


@pytest.mark.parametrize("on_simulated", [True, False])
def test_a_look_under_way_makes_the_other_half_worth_taking(on_simulated: bool) -> None:
    done = advice(place("first"), place("second"), pending=("first",), on_simulated=on_simulated)
    assert names(done) == ["second", None]
    assert done.net_value == pytest.approx(0.45 - 0.03, abs=0.02)
    assert done.ranking.value_of_perfect_information == pytest.approx(0.45, abs=0.02)
    assert done.ranking.looks[1].assistance.voa == pytest.approx(0.0, abs=0.05)
    both = advice(place("first"), place("second"), pending=("second", "first"), on_simulated=on_simulated)
    assert both.ranking.value_of_perfect_information == pytest.approx(0.0, abs=0.02)
    assert names(both) == [None, None]


def test_pairs_may_be_made_while_a_look_is_under_way() -> None:
    done = advice(place("first"), place("second"), pending=("blind",))
    assert names(done) == ["first", "second"]
    assert done.net_value == pytest.approx(0.45 - 0.06, abs=0.02)
