import math
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from tests.support import twin
from tests.voa_core.worlds import RULE_NAMES, lidar_of, parameters_of
from voa_core.checks import Floats
from voa_core.errors import InvalidInput, UnknownName
from voa_core.rules.beam import Beam
from voa_core.rules.distances import coded, squared_distance
from voa_core.rules.registry import RULES, defaults, rule_of

INF = math.inf
LIDAR = lidar_of(8, range_max=2.0)
PLAIN_BEAM: dict[str, float] = {
    "z_hit": 0.6,
    "z_short": 0.1,
    "z_no_return": 0.2,
    "z_random": 0.1,
    "sigma_hit_m": 0.02,
    "lambda_short_per_m": 1.5,
    "temper": 1.0,
}


def log_weight(name: str, observed: list[float], predicted: list[float], **parameters: float) -> float:
    rule = rule_of(name, LIDAR, **parameters)
    return float(rule.log_weights(rule.statistic(np.array([observed]), np.array([predicted])), len(observed))[0, 0])


def test_coding_caps_returns_and_gives_no_returns_a_number() -> None:
    assert coded(np.array([0.5, 1.5, INF]), 1.0).tolist() == [0.5, 1.0, 1.0]
    assert coded(np.array([INF], dtype=np.float32), 1.0).dtype == np.float32


def test_distances_are_between_coded_ranges() -> None:
    observed = np.array([[0.5, INF, 3.0], [0.2, 0.3, INF]])
    predicted = np.array([[0.2, 0.6, INF]])
    np.testing.assert_allclose(squared_distance(observed, predicted, 1.0), [[0.25], [0.09]])


@pytest.mark.parametrize(
    ("off", "agrees"), [(0.0, True), (0.008, True), (0.008 + 5e-10, True), (0.008 + 2e-9, False), (-0.0081, False)]
)
def test_margin_requires_every_beam_to_agree_within_it(off: float, agrees: bool) -> None:
    assert log_weight("margin", [0.5 + off, 0.4, INF], [0.5, 0.4, INF]) == (0.0 if agrees else -INF)


def test_margin_compares_coded_ranges() -> None:
    assert log_weight("margin", [0.995, 1.7], [INF, 1.2], no_return_m=1.0) == 0.0
    assert log_weight("margin", [0.99], [INF], no_return_m=1.0) == -INF


def test_exponential_by_hand() -> None:
    assert log_weight("exponential", [0.5, INF], [0.8, 0.6], no_return_m=1.0) == pytest.approx(-0.5)


def test_gaussian_by_hand() -> None:
    assert log_weight("gaussian", [0.5, INF], [0.8, 0.6], no_return_m=1.0) == pytest.approx(-0.125)
    assert log_weight("gaussian", [0.5, INF], [0.8, 0.6], no_return_m=1.0, sigma_m=0.5) == pytest.approx(-0.5)


def test_inverse_rmsd_by_hand_and_never_beyond_its_floor() -> None:
    rmsd = 0.5 / math.sqrt(2.0)
    weight = log_weight("inverse_rmsd", [0.5, INF], [0.8, 0.6], no_return_m=1.0)
    assert weight == pytest.approx(-math.log(rmsd))
    assert log_weight("inverse_rmsd", [0.5], [0.5]) == pytest.approx(math.log(1000.0))
    assert log_weight("inverse_rmsd", [0.5], [0.5], floor_m=0.01) == pytest.approx(math.log(100.0))


@pytest.mark.parametrize(
    ("observed", "predicted", "weight"),
    [
        (INF, 0.5, 0.2),
        (INF, INF, 0.3 + 0.2),
        (0.5, INF, 0.3 / 2.0 + 0.1 * 1.5 * math.exp(-0.75) / (1.0 - math.exp(-3.0)) + 0.1 / 2.0),
        (
            0.5,
            0.5,
            0.6 / (0.02 * math.sqrt(2.0 * math.pi)) + 0.1 * 1.5 * math.exp(-0.75) / (1.0 - math.exp(-0.75)) + 0.1 / 2.0,
        ),
        (0.54, 0.5, 0.6 * math.exp(-2.0) / (0.02 * math.sqrt(2.0 * math.pi)) + 0.1 / 2.0),
        (1.5, 0.5, 0.1 / 2.0),
    ],
)
def test_beam_by_hand_for_every_pair_of_classes(observed: float, predicted: float, weight: float) -> None:
    assert log_weight("beam", [observed], [predicted], **PLAIN_BEAM) == pytest.approx(math.log(weight), abs=1e-12)


def test_beam_grows_less_sure_of_far_hits() -> None:
    # sigma(z*) = max(0.02, 0.02 z*): twice as wide at 2 m.
    at_peak = log_weight("beam", [2.0], [2.0], **{**PLAIN_BEAM, "z_short": 0.0, "z_random": 0.0, "z_no_return": 0.0})
    assert at_peak == pytest.approx(-math.log(0.04 * math.sqrt(2.0 * math.pi)))


def test_beam_shares_are_scaled_to_sum_to_1() -> None:
    tenfold = {name: value * 10.0 if name.startswith("z_") else value for name, value in PLAIN_BEAM.items()}
    observed, predicted = [0.5, INF, 0.5, INF], [0.52, 0.5, INF, INF]
    assert log_weight("beam", observed, predicted, **tenfold) == pytest.approx(
        log_weight("beam", observed, predicted, **PLAIN_BEAM)
    )


def test_beam_is_tempered() -> None:
    halved = {**PLAIN_BEAM, "temper": 0.5}
    observed, predicted = [0.5, INF], [0.52, 0.5]
    assert log_weight("beam", observed, predicted, **halved) == pytest.approx(
        0.5 * log_weight("beam", observed, predicted, **PLAIN_BEAM)
    )


def test_beam_rules_out_a_pose_only_where_a_share_is_0() -> None:
    assert log_weight("beam", [INF], [0.5], **{**PLAIN_BEAM, "z_no_return": 0.0}) == -INF
    assert math.isfinite(log_weight("beam", [1.9] * 200, [0.1] * 200, **PLAIN_BEAM))


def test_beam_multiplies_many_beams_without_losing_them_to_underflow_or_overflow() -> None:
    sharp = {**PLAIN_BEAM, "sigma_hit_m": 1e-6}
    lidar = replace(LIDAR, noise_ratio=0.0)
    rule = rule_of("beam", lidar, **sharp)
    for observed, predicted in ((np.full((1, 400), 0.5), 0.5), (np.full((1, 400), 1.5), 0.5)):
        many = rule.statistic(observed, np.full((1, 400), predicted))[0, 0]
        one = rule.statistic(observed[:, :1], np.array([[predicted]]))[0, 0]
        assert many == pytest.approx(400.0 * one, rel=1e-12)


def test_beam_without_random_returns_still_weighs_what_is_far_off() -> None:
    # Densities of e^-200 and e^-648: a product of the two does not fit a float64, their logarithms do.
    bare = {**PLAIN_BEAM, "z_random": 0.0, "z_short": 0.0}
    observed, predicted = [0.5 + 20 * 0.02, 0.5 + 36 * 0.02, 0.5 + 36 * 0.02], [0.5] * 3
    expected = -200.0 - 2 * 648.0 + 3.0 * math.log(0.75 / (0.02 * math.sqrt(2.0 * math.pi)))
    assert log_weight("beam", observed, predicted, **bare) == pytest.approx(expected)


def test_beam_without_random_returns_rules_out_what_is_beyond_all_measure() -> None:
    bare = {**PLAIN_BEAM, "z_random": 0.0, "z_short": 0.0}
    assert log_weight("beam", [0.5, 1.9], [0.5, 0.5], **bare) == -INF


@pytest.mark.parametrize("name", RULE_NAMES)
@settings(max_examples=30, deadline=None)
@given(seed=st.integers(0, 2**32 - 1))
def test_weights_agree_with_the_twin_for_any_parameters(name: str, seed: int) -> None:
    rng = np.random.default_rng(seed)
    changed = {"no_return_m": float(rng.uniform(0.5, 3.0))}
    if name == "beam":
        changed |= {share: float(rng.uniform(0.05, 3.0)) for share in ("z_hit", "z_short", "z_no_return", "z_random")}
        changed |= {"sigma_hit_m": float(rng.uniform(0.005, 0.2)), "temper": float(rng.uniform(0.1, 1.0))}
    else:
        own = {"margin": "margin_m", "gaussian": "sigma_m", "inverse_rmsd": "floor_m"}
        changed |= {own[name]: float(rng.uniform(0.05, 0.6))} if name in own else {}
    ranges: Floats = rng.uniform(0.1, 1.9, (5, 4))
    ranges[rng.uniform(size=ranges.shape) < 0.3] = INF
    rule = rule_of(name, LIDAR, **changed)
    ours = rule.log_weights(rule.statistic(ranges[:2], ranges), 4)
    parameters = parameters_of(name, LIDAR, **changed)
    expected = [[twin.log_weight(name, parameters, list(o), list(p)) for p in ranges] for o in ranges[:2]]
    np.testing.assert_allclose(ours, expected, rtol=0, atol=1e-11)
    np.testing.assert_allclose(
        rule.statistic_among(ranges), rule.statistic(ranges, ranges), rtol=1e-14, atol=0 if name == "margin" else 1e-14
    )


@pytest.mark.parametrize("name", RULE_NAMES)
def test_rules_keep_the_float_type_that_they_are_given(name: str) -> None:
    rule = rule_of(name, LIDAR)
    ranges = np.array([[0.5, INF], [0.6, 0.5]], dtype=np.float32)
    statistic = rule.statistic(ranges, ranges)
    assert statistic.dtype == np.float32
    assert rule.statistic_among(ranges).dtype == np.float32
    assert rule.log_weights(statistic, 2).dtype == np.float32


@pytest.mark.parametrize("name", RULE_NAMES)
def test_no_return_m_belongs_to_every_rule_and_defaults_to_range_max(name: str) -> None:
    assert rule_of(name, LIDAR).no_return_m == 2.0
    assert rule_of(name, LIDAR, no_return_m=1.0).no_return_m == 1.0


def test_defaults_are_those_of_the_design() -> None:
    assert defaults("margin", LIDAR) == {"no_return_m": 2.0, "margin_m": 0.008}
    assert defaults("exponential", LIDAR) == {"no_return_m": 2.0}
    assert defaults("gaussian", LIDAR) == {"no_return_m": 2.0, "sigma_m": 1.0}
    assert defaults("inverse_rmsd", LIDAR) == {"no_return_m": 2.0, "floor_m": 0.001}


def test_defaults_of_beam_come_from_the_lidar() -> None:
    parameters = defaults("beam", lidar_of(360, increment=math.radians(-1.0)))
    assert parameters["sigma_hit_m"] == 0.01
    assert parameters["z_no_return"] == pytest.approx(0.1)
    assert sum(parameters[share] for share in ("z_hit", "z_short", "z_no_return", "z_random")) == pytest.approx(1.0)
    assert parameters["temper"] == pytest.approx(0.25)
    assert defaults("beam", lidar_of(4))["temper"] == 1.0
    fine = lidar_of(8, increment=math.radians(-0.25))
    assert defaults("beam", fine)["temper"] == pytest.approx(0.0625)
    assert defaults("beam", fine, spread=True) == defaults("beam", fine) | {"temper": pytest.approx(0.125)}
    assert defaults("beam", lidar_of(120), spread=True)["temper"] == 1.0
    assert defaults("gaussian", fine, spread=True) == defaults("gaussian", fine)


def test_beam_defaults_stay_shares_for_a_lidar_that_loses_nearly_everything() -> None:
    assert defaults("beam", replace(LIDAR, dropout=0.99))["z_hit"] == 0.0
    assert isinstance(rule_of("beam", replace(LIDAR, dropout=0.99)), Beam)


def test_a_rule_that_does_not_exist_is_refused_with_those_that_do() -> None:
    with pytest.raises(UnknownName, match="there is no update rule 'tau'; there are: 'margin', 'exponential'"):
        rule_of("tau", LIDAR)


@pytest.mark.parametrize(
    ("name", "parameter"), [("exponential", "sigma_m"), ("margin", "floor_m"), ("beam", "range_max")]
)
def test_a_parameter_that_its_rule_does_not_have_is_refused_with_those_that_it_has(name: str, parameter: str) -> None:
    with pytest.raises(UnknownName, match=f"'{parameter}'; there are: 'no_return_m'") as caught:
        rule_of(name, LIDAR, **{parameter: 1.0})
    assert caught.value.known == list(defaults(name, LIDAR))


@pytest.mark.parametrize(
    ("name", "parameters", "message"),
    [
        ("margin", {"margin_m": 0.0}, "margin_m: expected a number above 0.0"),
        ("exponential", {"no_return_m": -1.0}, "no_return_m: expected a number above 0.0"),
        ("gaussian", {"sigma_m": math.nan}, "sigma_m: expected a number above 0.0"),
        ("inverse_rmsd", {"floor_m": INF}, "floor_m: expected a finite number"),
        ("beam", {"sigma_hit_m": 0.0}, "sigma_hit_m: expected a number above 0.0"),
        ("beam", {"z_short": -0.1}, "z_short: expected a number of at least 0.0"),
        ("beam", {"temper": 0.0}, "temper: expected a number above 0 and at most 1, got 0.0"),
        ("beam", {"temper": 1.1}, "temper: expected a number above 0 and at most 1, got 1.1"),
        (
            "beam",
            {"z_hit": 0.0, "z_short": 0.0, "z_no_return": 0.0, "z_random": 0.0},
            "z_hit, z_short, z_no_return, z_random: expected a sum above 0",
        ),
    ],
)
def test_a_parameter_out_of_its_limits_is_refused(name: str, parameters: dict[str, Any], message: str) -> None:
    with pytest.raises(InvalidInput, match=message):
        rule_of(name, LIDAR, **parameters)


def test_every_rule_of_the_contract_exists() -> None:
    assert list(RULES) == ["margin", "exponential", "gaussian", "inverse_rmsd", "beam"]
