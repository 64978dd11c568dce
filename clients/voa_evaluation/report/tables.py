"""CSV files of an evaluation of looks: its rows, and the figures that are computed from them."""

import csv
from collections.abc import Iterable, Iterator, Sequence
from pathlib import Path

from voa_evaluation.looks.results import Results
from voa_evaluation.statistics import Interval

Cell = str | int | float | bool | None
NO_LOOK = "none"
"""Content of the column `sensor` without a look."""


def write_tables(folder: Path, results: Results) -> dict[str, Path]:
    """Write all CSV files to a folder; return their paths by a description of their contents."""
    folder.mkdir(parents=True, exist_ok=True)
    tables: dict[str, tuple[str, Sequence[str], Iterable[Sequence[Cell]]]] = {
        "every look": ("voa-looks.csv", _LOOKS, _looks(results)),
        "every choice": ("voa-choices.csv", _CHOICES, _choices(results)),
        "worth per sensor configuration": ("voa-worth.csv", _WORTH, _worth(results)),
        "gain by choosing": ("voa-gains.csv", _GAINS, _gains(results)),
        "success per policy": ("voa-policies.csv", _POLICIES, _policies(results)),
        "calibration": ("voa-calibration.csv", _BINS, _bins(results)),
        "every disturbed look": ("voa-sensitivity-drops.csv", _POINTS, _points(results)),
        "sensitivity": ("voa-sensitivity.csv", _LEVELS, _levels(results)),
    }
    files = {}
    for contents, (name, header, rows) in tables.items():
        files[contents] = folder / name
        write_csv(folder / name, header, rows)
    return files


def write_csv(file: Path, header: Sequence[str], rows: Iterable[Sequence[Cell]]) -> None:
    """Write a CSV file: numbers with six decimals, True and False as 1 and 0, None as an empty cell."""
    with file.open("w", encoding="utf-8", newline="") as lines:
        writer = csv.writer(lines, lineterminator="\n")
        writer.writerow(header)
        writer.writerows([_text(cell) for cell in row] for row in rows)


def _text(cell: Cell) -> str:
    if cell is None:
        return ""
    if isinstance(cell, bool):
        return str(int(cell))
    if isinstance(cell, float):
        return f"{round(cell, 6) + 0.0:.6f}"  # + 0.0: no minus before a zero
    return str(cell)


def _interval(interval: Interval | None) -> tuple[Cell, ...]:
    return (None, None, None) if interval is None else (interval.value, interval.low, interval.high)


_LOOKS = (
    *("object", "belief", "drop", "pose", "rule", "sensor", "voa", "expected_before", "expected_after"),
    *("reason", "belief_in_truth", "grasp", "result", "success"),
)


def _looks(results: Results) -> Iterator[Sequence[Cell]]:
    for row in results.rows.rows:
        own = row.object, row.kind, row.drop, row.pose, row.rule
        for look in (row.before, *row.looks):
            worth = look.sensor or NO_LOOK, look.voa, row.before.expected, look.expected
            yield *own, *worth, look.reason, look.truth, look.grasp, look.result, look.success


_CHOICES = ("object", "belief", "drop", "rule", "policy", "sensor", "grasp", "success")


def _choices(results: Results) -> Iterator[Sequence[Cell]]:
    for row in results.rows.rows:
        for policy in results.setting.policies:
            look = row.of_policy(policy)
            sensor = look.sensor or NO_LOOK
            yield row.object, row.kind, row.drop, row.rule, policy, sensor, look.grasp, look.success


_WORTH = (
    *("object", "belief", "rule", "sensor", "voa", "aecd", "aecd_low", "aecd_high"),
    *("achieved", "achieved_low", "achieved_high", "successes_with", "successes_without", "drops", "not_accepted"),
)


def _worth(results: Results) -> Iterator[Sequence[Cell]]:
    for worth in results.worths:
        own = worth.object, worth.kind, worth.rule, worth.sensor, worth.voa
        counts = worth.with_look, worth.without, worth.achieved.count, worth.not_accepted
        yield *own, *_interval(worth.aecd), *_interval(worth.achieved), *counts


_GAINS = (
    *("object", "belief", "rule", "delta", "delta_low", "delta_high", "best_in_hindsight"),
    *("delta_star", "delta_star_low", "delta_star_high", "over_random", "over_random_low", "over_random_high"),
    *("tau_achieved", "tau_achieved_low", "tau_achieved_high", "tau_aecd", "tau_aecd_low", "tau_aecd_high", "drops"),
)


def _gains(results: Results) -> Iterator[Sequence[Cell]]:
    for gain in results.gains:
        own = gain.object, gain.kind, gain.rule
        values = *_interval(gain.delta), gain.best, *_interval(gain.delta_star), *_interval(gain.over_random)
        yield *own, *values, *_interval(gain.tau), *_interval(gain.tau_aecd), gain.delta.count


_POLICIES = (
    *("object", "belief", "rule", "policy", "successes", "drops", "share", "low", "high"),
    *("voa_ahead_by", "voa_ahead_low", "voa_ahead_high"),
)


def _policies(results: Results) -> Iterator[Sequence[Cell]]:
    for outcome in results.outcomes:
        own = outcome.object or "all", outcome.kind, outcome.rule, outcome.policy
        rate = outcome.rate
        yield *own, rate.successes, rate.drops, rate.share, *rate.interval, *_interval(outcome.behind)


_BINS = ("belief", "rule", "from", "below", "mean_voa", "achieved", "low", "high", "looks", "drops")


def _bins(results: Results) -> Iterator[Sequence[Cell]]:
    for each in results.bins:
        own = each.kind, each.rule, each.low, each.high, each.voa
        yield *own, *_interval(each.achieved), each.achieved.count, each.drops


_POINTS = (
    *("disturbance", "level", "stated", "rule", "object", "drop", "sensor", "reason", "grasp"),
    *("success", "success_without"),
)


def _points(results: Results) -> Iterator[Sequence[Cell]]:
    for point in results.points:
        own = point.disturbance, point.level, point.stated, point.rule, point.object, point.drop
        yield *own, point.sensor or NO_LOOK, point.reason, point.grasp, point.success, point.blind


_LEVELS = (
    *("disturbance", "level", "stated", "rule", "successes", "successes_without", "drops", "not_accepted"),
    *("gain", "low", "high"),
)


def _levels(results: Results) -> Iterator[Sequence[Cell]]:
    for level in results.levels:
        own = level.disturbance, level.level, level.stated, level.rule
        counts = level.rate.successes, level.blind.successes, level.rate.drops, level.not_accepted
        yield *own, *counts, *_interval(level.gain)
