"""Selections from the results of an evaluation of values, and the words by which the report names them."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from types import MappingProxyType

from voa_evaluation.statistics import Interval
from voa_evaluation.values.cases import HINTED
from voa_evaluation.values.policies import (
    BEAMS,
    ENTROPY,
    ENTROPY_EXACT,
    NEAREST,
    ORACLE,
    RANDOM,
    VOA,
    VOA_EXACT,
)
from voa_evaluation.values.results import ALL, Confirmation, Difference, Promise, SeveralLooks, Values, WayValue
from voa_evaluation.values.setting import PLANNED_RULE

WAY_NAMES: Mapping[str, str] = MappingProxyType(
    {
        RANDOM: "random place",
        NEAREST: "nearest place",
        BEAMS: "most beams",
        ENTROPY_EXACT: "least entropy, exact scans",
        ENTROPY: "least entropy",
        VOA_EXACT: "VOA over exact scans",
        VOA: "VOA",
        ORACLE: "best place known",
    }
)
"""Names of the ways of choosing a look in the report, from the simplest to the unreachable one."""


@dataclass(frozen=True)
class Shown:
    """The rows of an evaluation that the report shows: hinted beliefs, mostly of rule `beam` and one robot error.

    Attributes:
        values: results of the evaluation.
    """

    values: Values

    @property
    def everything(self) -> str:
        """Value of the field `object` in rows over all objects: the only object's name if there is one."""
        names = self.values.counts.objects
        return names[0] if len(names) == 1 else ALL

    @property
    def objects(self) -> tuple[str, ...]:
        """Names of the objects."""
        return self.values.counts.objects

    @property
    def error(self) -> str:
        """Name of the robot error of the answers: the second of the setting (1 cm), or the only one."""
        return self.errors[min(1, len(self.errors) - 1)]

    @property
    def errors(self) -> list[str]:
        """Names of all robot errors."""
        return [error.name for error in self.values.setting.robot_errors]

    @property
    def rules(self) -> list[str]:
        """Names of the update rules, the planned one first."""
        return sorted(self.values.setting.rules, key=lambda rule: rule != self.rule)

    @property
    def rule(self) -> str:
        """Name of the update rule of the answers: `beam`, or the first of the setting."""
        rules = self.values.setting.rules
        return PLANNED_RULE if PLANNED_RULE in rules else rules[0]

    def ways(self, name: str | None = None, rule: str | None = None, error: str | None = None) -> dict[str, WayValue]:
        """Select the rows of all ways of choosing, by way; None stands for all objects and the answers' rule, error."""
        key = name or self.everything, rule or self.rule, error or self.error, HINTED
        rows = self.values.ways
        return {row.way: row for row in rows if (row.object, row.rule, row.robot_error, row.belief) == key}

    def promise(self, promise: str, rule: str | None = None, error: str | None = None) -> Promise:
        """Select the row of a promise (`simulated` or `exact`) over all objects."""
        key = self.everything, rule or self.rule, error or self.error, HINTED, promise
        rows = self.values.promises
        return next(row for row in rows if (row.object, row.rule, row.robot_error, row.belief, row.promise) == key)

    def differences(self, name: str | None = None, error: str | None = None) -> dict[str, Difference]:
        """Select the differences of VOA from other ways under the answers' rule, by way."""
        key = name or self.everything, self.rule, error or self.error, HINTED
        rows = self.values.differences
        return {row.way: row for row in rows if (row.object, row.rule, row.robot_error, row.belief) == key}

    def all_differences(self, way: str, *, alone: bool) -> list[Difference]:
        """Select the differences of VOA from a way under every rule and robot error.

        Args:
            way: the other way.
            alone: True for each object alone, False for all objects together.
        """
        own = [row for row in self.values.differences if (row.way, row.belief) == (way, HINTED)]
        return [row for row in own if (row.object != self.everything) == alone]

    def several(self, way: str) -> list[SeveralLooks]:
        """Select the rows of a way's sessions of several looks, by number of looks; empty without sessions."""
        key = self.everything, self.rule, self.error, way
        return [row for row in self.values.several if (row.object, row.rule, row.robot_error, row.way) == key]

    def confirmation(self) -> Confirmation | None:
        """Select the drops in MuJoCo of all objects; None without drops."""
        return next((row for row in self.values.confirmations if row.object == self.everything), None)


def of_hundred(success: float) -> str:
    """Write a probability of success as a number of grasps in 100."""
    return f"{100.0 * success:.0f}"


def with_interval(interval: Interval | None, *, signs: bool = True) -> str:
    """Write a figure with its 95 % interval; a dash for None."""
    if interval is None:
        return "-"
    form = "+.3f" if signs else ".3f"
    value, low, high = (f"{round(figure, 3) + 0.0:{form}}" for figure in (interval.value, interval.low, interval.high))
    return f"{value} [{low}, {high}]"


def listed(names: Sequence[str]) -> str:
    """Join names as in a sentence: "a, b and c"."""
    return names[0] if len(names) == 1 else f"{', '.join(names[:-1])} and {names[-1]}"


def unbroken(robot_error: str) -> str:
    """Replace the spaces in the name of a robot error, so that a narrow column keeps it in one line."""
    return robot_error.replace(" ", "\u00a0")
