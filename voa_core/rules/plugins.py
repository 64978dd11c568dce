"""Update rules that another package provides: how they are made, and the checks of what they compute.

A package names a `RuleFactory` in its entry points of the group `voa.rules`; `deploy/docs/own-rule.md` is the guide.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, Protocol

import numpy as np

from voa_core.checks import number
from voa_core.errors import InvalidInput, RuleFault, RuleNotInstalled
from voa_core.kernels import Array
from voa_core.lidars import LidarModel
from voa_core.rules.protocol import UpdateRule

_METHODS = ("statistic", "statistic_among", "log_weights")
_REFUSALS = (ValueError, TypeError, KeyError)


class RuleFactory(Protocol):
    """A function or class that makes an update rule from the parameters in a scenario."""

    def __call__(self, parameters: Mapping[str, Any], no_return_m: float, lidar: LidarModel, /) -> UpdateRule:
        """Make the rule.

        Args:
            parameters: the scenario's, as JSON gives them: the factory checks them.
            no_return_m: range that stands for a no-return, metres; the rule must have it as its `no_return_m`.
            lidar: the scenario's, for defaults.

        Raises:
            ValueError, TypeError, KeyError: the parameters are wrong; the message is shown to the author.
        """


@dataclass(frozen=True)
class CheckedRule:
    """A rule of another package whose results are checked for type, shape, NaN and +inf, and copied.

    Attributes:
        name: of the rule, for messages.
        rule: the rule that the package made.
        no_return_m: range that stands for a no-return, metres.
    """

    name: str
    rule: UpdateRule
    no_return_m: float

    def statistic(self, observed: Array, predicted: Array) -> Array:
        """Sum over beams for each pair of scans, (m, c) and (n, c) give (m, n); raises RuleFault."""
        return self._sums("statistic", (len(observed), len(predicted)), observed, predicted)

    def statistic_among(self, ranges: Array) -> Array:
        """Sum over beams for each pair of the scans (n, c): (n, n); raises RuleFault."""
        return self._sums("statistic_among", (len(ranges), len(ranges)), ranges)

    def log_weights(self, statistic: Array, beams: int, /) -> Array:
        """Logarithms of the weights, in the shape of `statistic`; raises RuleFault."""
        result = self._result("log_weights", statistic.shape, statistic.dtype, statistic, beams)
        if (result == np.inf).any():
            raise RuleFault(self.name, "log_weights", "an infinite weight", "logarithms below +inf")
        return result

    def _sums(self, method: str, shape: tuple[int, int], *scans: Array) -> Array:
        """Statistics of scans (., c), checked; without a beam they are 0, whatever the rule."""
        if scans[0].shape[1] == 0:
            return np.zeros(shape, dtype=scans[0].dtype)
        return self._result(method, shape, scans[0].dtype, *scans)

    def _result(self, method: str, shape: tuple[int, ...], dtype: np.dtype[Any], *arguments: Any) -> Array:
        """Call a method of the rule; its result as an array of its own, of the expected shape and float type."""
        expected = f"an array of numbers of shape {shape}"
        try:
            returned = getattr(self.rule, method)(*arguments)
        except Exception as error:
            raise RuleFault(self.name, method, f"{type(error).__name__}: {error}", expected) from error
        try:
            result: Array = np.array(returned, dtype=dtype)
        except (TypeError, ValueError, OverflowError) as error:
            raise RuleFault(self.name, method, f"a {type(returned).__name__}", expected) from error
        if result.shape != shape:
            raise RuleFault(self.name, method, f"an array of shape {result.shape}", expected)
        if np.isnan(result).any():
            raise RuleFault(self.name, method, "NaN", "no NaN")
        return result


def installed_rule(
    installed: Mapping[str, RuleFactory],
    name: str,
    parameters: Mapping[str, Any],
    no_return_m: float,
    lidar: LidarModel,
) -> CheckedRule:
    """Make the update rule `name` of another package.

    Args:
        installed: the factories of all such rules by name.
        name: of the rule.
        parameters: the rule's own, checked by its factory.
        no_return_m: range that stands for a no-return, metres.
        lidar: for the rule's defaults.

    Raises:
        RuleNotInstalled: no package provides the rule.
        InvalidInput: the factory refuses the parameters, or `no_return_m` is not above 0.
        RuleFault: the factory fails in another way, or makes no update rule.
    """
    if name not in installed:
        raise RuleNotInstalled(name, sorted(installed))
    number("no_return_m", no_return_m, above=0.0)
    try:
        rule = installed[name](dict(parameters), no_return_m, lidar)
    except _REFUSALS as error:
        detail = f"{type(error).__name__}: {error}" if isinstance(error, KeyError) else str(error)
        raise InvalidInput("update.parameters", f"what the update rule {name!r} accepts", detail) from error
    except Exception as error:
        raise RuleFault(name, "its factory", f"{type(error).__name__}: {error}", "an update rule") from error
    for method in _METHODS:
        if not callable(getattr(rule, method, None)):
            raise RuleFault(name, "its factory", f"an object without the method {method!r}", "an update rule")
    return CheckedRule(name, rule, no_return_m)
