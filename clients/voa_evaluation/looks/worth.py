"""Values of looks per object, kind of belief, rule and sensor configuration: VOA, AECD and achieved value."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from voa_evaluation.looks.rows import Rows
from voa_evaluation.looks.setting import Belief
from voa_evaluation.statistics import (
    Interval,
    bootstrap_mean,
    bootstrap_rank_correlation,
    rank_correlation,
)


@dataclass(frozen=True)
class Worth:
    """Values of the looks from a sensor configuration.

    Attributes:
        object: name of the object.
        kind: of the belief.
        rule: name of the update rule.
        sensor: name of the sensor configuration.
        voa: Value of Assistance over predicted scans, mean over the drops; equal for all drops with a uniform belief.
        aecd: rise of the expected score over the scans that were taken, mean over the drops.
        achieved: success rate with the look less that without it, with its paired interval.
        with_look, without: successes of `achieved.count` drops.
        not_accepted: number of scans that were refused, or that no pose explained.
    """

    object: str
    kind: Belief
    rule: str
    sensor: str
    voa: float
    aecd: Interval
    achieved: Interval
    with_look: int
    without: int
    not_accepted: int


@dataclass(frozen=True)
class Gain:
    """Gain of choosing looks by VOA, for an object, a kind of belief and an update rule.

    Attributes:
        object: name of the object.
        kind: of the belief.
        rule: name of the update rule.
        delta: achieved value of the looks that VOA chose.
        best: sensor configuration with the highest achieved value, which is known in hindsight only.
        delta_star: its achieved value.
        over_random: delta less the mean achieved value of all sensor configurations.
        tau: Kendall's tau-b over the sensor configurations, of mean VOA against achieved value; None: undefined.
        tau_aecd: Kendall's tau-b of mean VOA against AECD.
    """

    object: str
    kind: Belief
    rule: str
    delta: Interval
    best: str
    delta_star: Interval
    over_random: Interval
    tau: Interval | None
    tau_aecd: Interval | None


def worths(rows: Rows, seed: int) -> list[Worth]:
    """Compute the values for every object, kind of belief, update rule and sensor configuration, in order."""
    return [worth for group in _groups(rows) for worth in _worths_of(group, seed)]


def gains(rows: Rows, seed: int) -> list[Gain]:
    """Compute the gain for every object, kind of belief and update rule, in order."""
    return [_gain_of(group, seed) for group in _groups(rows)]


def pooled_tau(values: Sequence[Worth]) -> float | None:
    """Compute Kendall's tau-b of VOA against achieved value over all given values; None: undefined."""
    voa = np.array([worth.voa for worth in values])
    return rank_correlation(voa, np.array([worth.achieved.value for worth in values]))


def _groups(rows: Rows) -> Iterator[Rows]:
    for name in rows.objects:
        for kind in rows.kinds:
            for rule in rows.rules:
                yield rows.of(name=name, kind=kind, rule=rule)


def _worths_of(group: Rows, seed: int) -> Iterator[Worth]:
    first = group.rows[0]
    predicted, measured, achieved = group.predicted(), group.measured(), group.achieved()
    for column, look in enumerate(first.looks):
        yield Worth(
            object=first.object,
            kind=first.kind,
            rule=first.rule,
            sensor=look.sensor or "",
            voa=float(predicted[:, column].mean()),
            aecd=bootstrap_mean([measured[:, column]], seed),
            achieved=bootstrap_mean([achieved[:, column]], seed),
            with_look=sum(row.looks[column].success for row in group.rows),
            without=sum(row.before.success for row in group.rows),
            not_accepted=sum(row.looks[column].reason != "" for row in group.rows),
        )


def _gain_of(group: Rows, seed: int) -> Gain:
    first = group.rows[0]
    achieved = group.achieved()
    chosen = np.array([float(row.of_policy("voa").success) - row.before.success for row in group.rows])
    best = int(np.argmax(np.round(achieved.mean(axis=0), 12)))
    voa = np.round(group.predicted().mean(axis=0), 12)
    return Gain(
        object=first.object,
        kind=first.kind,
        rule=first.rule,
        delta=bootstrap_mean([chosen], seed),
        best=first.looks[best].sensor or "",
        delta_star=bootstrap_mean([achieved[:, best]], seed),
        over_random=bootstrap_mean([chosen - achieved.mean(axis=1)], seed),
        tau=bootstrap_rank_correlation(voa, achieved, seed),
        tau_aecd=bootstrap_rank_correlation(voa, group.measured(), seed),
    )
