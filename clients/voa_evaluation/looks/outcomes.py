"""What came of the grasps: success rates per policy, and paired differences from the policy that follows VOA."""

from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from voa_evaluation.grasp_scores import wilson
from voa_evaluation.looks.choices import POLICIES
from voa_evaluation.looks.rows import Rows
from voa_evaluation.looks.sensitivity import DISTURBANCES, Point
from voa_evaluation.looks.setting import Belief
from voa_evaluation.statistics import Interval, bootstrap_mean


@dataclass(frozen=True)
class Rate:
    """Successes of drops, with Wilson's interval."""

    successes: int
    drops: int

    @property
    def share(self) -> float:
        """k / n."""
        return self.successes / self.drops

    @property
    def interval(self) -> tuple[float, float]:
        """95 %."""
        return wilson(self.successes, self.drops)


@dataclass(frozen=True)
class Outcome:
    """One policy under one rule and kind of belief.

    Attributes:
        object: None: over all objects.
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
    """One point of a curve: the look that VOA recommends, at a level of a disturbance.

    Attributes:
        blind: the same drops without a look.
        gain: the difference, paired.
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
    """Over all objects, then per object; by kind, rule and policy."""
    found = []
    for name in (None, *rows.objects):
        for kind in rows.kinds:
            for rule in rows.rules:
                group = rows.of(target=name, kind=kind, rule=rule)
                ours = group.successes("voa")
                for policy in POLICIES:
                    theirs = group.successes(policy)
                    apart = [mine - other for mine, other in zip(ours, theirs, strict=True)]
                    rate = Rate(round(sum(float(each.sum()) for each in theirs)), len(group.rows))
                    found.append(Outcome(name, kind, rule, policy, rate, bootstrap_mean(apart, seed)))
    return found


def levels(points: Sequence[Point], seed: int) -> list[Level]:
    """One per disturbance, rule, whether stated, and level, in order; at level 0 nothing is there to state."""
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


def endings(rows: Rows, policy: str) -> dict[str, int]:
    """How the grasps of a policy ended, most frequent first."""
    found = Counter(row.of_policy(policy).result for row in rows.rows)
    return dict(sorted(found.items(), key=lambda item: (-item[1], item[0])))
