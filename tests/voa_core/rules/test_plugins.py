"""Rules of other packages: what their factories and methods may do, and how their faults are reported."""

from collections.abc import Callable, Mapping
from typing import Any, cast

import numpy as np
import pytest

from tests.voa_core.worlds import lidar_of
from voa_core.errors import InvalidInput, RuleFault, RuleNotInstalled
from voa_core.rules.distances import DistanceRule
from voa_core.rules.exponential import Exponential
from voa_core.rules.plugins import CheckedRule, RuleFactory, installed_rule
from voa_core.rules.protocol import UpdateRule

LIDAR = lidar_of(4)
RANGES = np.array([[0.5, np.inf], [0.6, 0.5], [0.7, 0.5]])


class Halves(DistanceRule):
    """w = exp(-d^2 / 2)."""

    def log_weights(self, statistic: Any, _beams: int, /) -> Any:
        return -0.5 * statistic


def halves(_parameters: Mapping[str, Any], no_return_m: float, _lidar: object, /) -> UpdateRule:
    return Halves(no_return_m)


def made(factory: Callable[..., object], **parameters: Any) -> CheckedRule:
    return installed_rule({"own": cast(RuleFactory, factory)}, "own", parameters, 1.0, LIDAR)


class Faulty:
    """A rule whose methods return what they are given at its making."""

    def __init__(self, result: object) -> None:
        self.no_return_m = 1.0
        self.result = result

    def answer(self, *_arguments: object) -> object:
        if isinstance(self.result, Exception):
            raise self.result
        return self.result

    statistic = statistic_among = log_weights = answer


def faulty(result: object) -> CheckedRule:
    return made(lambda *_: Faulty(result))


@pytest.mark.parametrize("dtype", [np.float32, np.float64])
def test_a_rule_gives_what_it_computes_in_the_float_type_of_the_scans(dtype: type[np.floating]) -> None:
    rule, ranges = made(halves), RANGES.astype(dtype)
    assert rule.no_return_m == 1.0
    np.testing.assert_array_equal(rule.statistic(ranges[:1], ranges), Halves(1.0).statistic(ranges[:1], ranges))
    among = rule.statistic_among(ranges)
    np.testing.assert_array_equal(among, Halves(1.0).statistic_among(ranges))
    assert among.dtype == rule.log_weights(among, 2).dtype == dtype
    np.testing.assert_array_equal(rule.log_weights(among, 2), -0.5 * among)


def test_results_are_copies_that_callers_may_overwrite() -> None:
    kept = np.zeros((3, 3))
    rule = faulty(kept)
    rule.statistic(RANGES, RANGES)[:] = 1.0
    rule.log_weights(kept, 2)[:] = 1.0
    assert not kept.any()


def test_without_a_beam_the_statistic_is_0_whatever_the_rule() -> None:
    assert faulty(ValueError("empty")).statistic(RANGES[:1, :0], RANGES[:, :0]).tolist() == [[0.0, 0.0, 0.0]]
    assert faulty(ValueError("empty")).statistic_among(RANGES[:, :0]).shape == (3, 3)


def test_a_weight_of_0_is_allowed() -> None:
    assert faulty([-np.inf, 0.0]).log_weights(np.zeros(2), 1).tolist() == [-np.inf, 0.0]


@pytest.mark.parametrize(
    ("result", "message"),
    [
        (
            ZeroDivisionError("by 0"),
            r"'own', which another package provides, failed in statistic: .* ZeroDivisionError",
        ),
        (np.zeros((3, 2)), r"expected an array of numbers of shape \(1, 3\), got an array of shape \(3, 2\)"),
        ("much", r"expected an array of numbers of shape \(1, 3\), got a str"),
        (None, r"expected no NaN, got NaN|expected an array of numbers of shape \(1, 3\)"),
        ([[0.0, np.nan, 0.0]], "expected no NaN, got NaN"),
    ],
)
def test_a_fault_names_the_rule_and_what_it_returned(result: object, message: str) -> None:
    with pytest.raises(RuleFault, match=message) as caught:
        faulty(result).statistic(RANGES[:1], RANGES)
    assert caught.value.name == "own"


def test_an_infinite_weight_is_a_fault() -> None:
    with pytest.raises(
        RuleFault, match=r"failed in log_weights: expected logarithms below .inf, got an infinite weight"
    ):
        faulty([np.inf]).log_weights(np.zeros(1), 1)


def test_a_rule_that_is_not_installed_is_refused_with_those_that_are() -> None:
    with pytest.raises(RuleNotInstalled, match="'own' is not installed here; installed are: 'a', 'b'") as caught:
        installed_rule({"b": halves, "a": halves}, "own", {}, 1.0, LIDAR)
    assert caught.value.known == ["a", "b"]
    with pytest.raises(RuleNotInstalled, match="installed are: none"):
        installed_rule({}, "own", {}, 1.0, LIDAR)


@pytest.mark.parametrize(
    ("error", "message"),
    [
        (ValueError("scale_m: a number above 0"), "update.parameters: .* got scale_m: a number above 0"),
        (TypeError("unexpected 'scale'"), "got unexpected 'scale'"),
        (KeyError("scale_m"), "got KeyError: 'scale_m'"),
    ],
)
def test_what_a_factory_refuses_is_the_authors_mistake(error: Exception, message: str) -> None:
    def refuse(*_arguments: object) -> UpdateRule:
        raise error

    with pytest.raises(InvalidInput, match=message):
        made(refuse)


def test_a_factory_gets_the_parameters_the_no_return_and_the_lidar() -> None:
    received: list[object] = []

    def factory(*arguments: object) -> UpdateRule:
        received.extend(arguments)
        return Exponential(1.0)

    made(factory, scale_m=0.1)
    assert received == [{"scale_m": 0.1}, 1.0, LIDAR]


def test_a_no_return_of_0_is_refused_before_the_factory_is_called() -> None:
    with pytest.raises(InvalidInput, match="no_return_m"):
        installed_rule({"own": halves}, "own", {}, 0.0, LIDAR)


def test_a_factory_that_fails_or_makes_no_rule_is_a_fault() -> None:
    with pytest.raises(RuleFault, match=r"failed in its factory: .* ZeroDivisionError"):
        made(lambda *_: 1 // 0)
    with pytest.raises(RuleFault, match="an object without the method 'statistic'"):
        made(lambda *_: object())
