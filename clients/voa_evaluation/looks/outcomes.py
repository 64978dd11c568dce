"""Success rates per policy, and paired differences from the policy that follows VOA."""

from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from voa_evaluation.looks.rows import Rows
from voa_evaluation.looks.sensitivity import DISTURBANCES, Point
from voa_evaluation.looks.setting import Belief
from voa_evaluation.statistics import Interval, bootstrap_mean
from voa_fleet.statistics import wilson


@dataclass(frozen=True)
class Rate:
    """Number of drops in which the object was lifted."""

    successes: int
    drops: int

    @property
    def share(self) -> float:
        """Successes divided by drops."""
        return self.successes / self.drops

    @property
    def interval(self) -> tuple[float, float]:
        """Wilson's 95 % interval of the probability of success."""
        return wilson(self.successes, self.drops)


@dataclass(frozen=True)
class Outcome:
    """Success of a policy under an update rule and a kind of belief.

    Attributes:
        object: name of the object; None: all objects.
        kind: of the belief.
        rule: name of the update rule.
        policy: name of the policy.
        rate: its successes.
        behind: success rate of VOA less that of this policy, resampled by drop within each object.
    """

    object: str | None
    kind: Belief
    rule: str
    policy: str
    rate: Rate
    behind: Interval


@dataclass(frozen=True)
class Level:
    """A point of a curve of sensitivity: success with the recommended look at a level of a disturbance.

    Attributes:
        disturbance: its name.
        level: its size.
        stated: True if the robot stated the uncertainty of its pose.
        rule: name of the update rule.
        rate: successes with the look.
        blind: successes without a look, in the same drops.
        gain: difference of the rates, paired.
        not_accepted: number of scans that were refused, or that no pose explained.
    """

    disturbance: str
    level: float
    stated: bool
    rule: str
    rate: Rate
    blind: Rate
    gain: Interval
    not_accepted: int


def outcomes(rows: Rows, seed: int) -> list[Outcome]:
    """Compute the success rates over all objects, then per object; by kind of belief, rule and policy."""
    rates = []
    for name in (None, *rows.objects):
        for kind in rows.kinds:
            for rule in rows.rules:
                group = rows.of(name=name, kind=kind, rule=rule)
                ours = group.successes("voa")
                for policy in rows.policies:
                    theirs = group.successes(policy)
                    apart = [mine - other for mine, other in zip(ours, theirs, strict=True)]
                    rate = Rate(round(sum(float(each.sum()) for each in theirs)), len(group.rows))
                    rates.append(Outcome(name, kind, rule, policy, rate, bootstrap_mean(apart, seed)))
    return rates


def levels(points: Sequence[Point], seed: int) -> list[Level]:
    """Compute a point per disturbance, rule, statement of the uncertainty, and level, in order."""
    groups: dict[tuple[str, str, bool, float], list[Point]] = {}
    for point in points:
        groups.setdefault((point.disturbance, point.rule, point.stated, point.level), []).append(point)
    order = [disturbance.name for disturbance in DISTURBANCES]
    rules = list(dict.fromkeys(point.rule for point in points))
    keys = sorted(groups, key=lambda key: (order.index(key[0]), rules.index(key[1]), key[2], key[3]))
    return [_level(groups[key], seed) for key in keys]


def _level(group: Sequence[Point], seed: int) -> Level:
    first = group[0]
    objects = dict.fromkeys(point.object for point in group)
    apart = [[float(point.success) - point.blind for point in group if point.object == name] for name in objects]
    return Level(
        disturbance=first.disturbance,
        level=first.level,
        stated=first.stated,
        rule=first.rule,
        rate=Rate(sum(point.success for point in group), len(group)),
        blind=Rate(sum(point.blind for point in group), len(group)),
        gain=bootstrap_mean([np.array(each) for each in apart], seed),
        not_accepted=sum(point.reason != "" for point in group),
    )


def result_counts(rows: Rows, policy: str) -> dict[str, int]:
    """Count the results of the grasps of a policy, the most frequent first."""
    counts = Counter(row.of_policy(policy).result for row in rows.rows)
    return dict(sorted(counts.items(), key=lambda item: (-item[1], item[0])))
