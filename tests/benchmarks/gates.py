"""Gates and goals of the ratios: what a run of the benchmarks must reach, and what it should."""

import re
from collections.abc import Sequence
from dataclasses import dataclass
from statistics import median_low

from tests.benchmarks.measure import Result


@dataclass(frozen=True)
class Gate:
    """Limit that the ratio of some results must keep.

    Attributes:
        pattern: regular expression that matches the whole names of these results.
        bound: the gate: a run that misses it fails.
        goal: the ratio that is aimed at; None: the gate is all that is demanded.
        is_cost: True if the ratio says how many times dearer ours is, so that the gate is an upper limit.
    """

    pattern: str
    bound: float
    goal: float | None = None
    is_cost: bool = False

    def kept_by(self, ratio: float) -> bool:
        """True if the ratio is on the right side of the gate."""
        return ratio <= self.bound if self.is_cost else ratio >= self.bound

    def reached_by(self, ratio: float) -> bool:
        """True if the ratio is on the right side of the goal; False where there is none."""
        if self.goal is None:
            return False
        return ratio <= self.goal if self.is_cost else ratio >= self.goal

    def margin(self, ratio: float) -> float:
        """Quotient by which a ratio is better than the gate: 1 at the gate, below 1 where it is missed."""
        return self.bound / ratio if self.is_cost else ratio / self.bound


GATES = (
    Gate(r"prediction, 1k faces, \w+ poses / embree kernel", 4.0),
    Gate(r"prediction, 10k faces, \w+ poses / embree kernel", 2.5),
    Gate(r"prediction, 100k faces, \w+ poses / embree kernel", 1.2),
    Gate(r"prediction, 1k faces, \w+ poses / trimesh\+embreex", 20.0, 60.0),
    Gate(r"prediction, 10k faces, \w+ poses / trimesh\+embreex", 14.0, 40.0),
    Gate(r"prediction, 100k faces, \w+ poses / trimesh\+embreex", 5.0, 20.0),
    Gate(r"weights, exponential, \w+ / scipy cdist", 15.0, 30.0),
    Gate(r"ranking, \d+ grasps, \w+ / numpy loop", 1.5, 3.0),
    Gate(r"ranking, \d+ grasps, \w+ / filterpy loop \(scaled\)", 15.0, 30.0),
    Gate(r"ranking, 20 grasps, float32, percent of the sgemm peak", 25.0, 45.0),
    Gate(r"ranking, 100 grasps, float32, percent of the sgemm peak", 60.0, 80.0),
    Gate(r"spread, beam: (weights of 256 scans|first ranking), a place / without", 8.0, 3.0, is_cost=True),
    Gate(r"spread, beam: scan update, remembered / without", 10.0, 4.0, is_cost=True),
    Gate(r"durable scan updates, .* / bare transactions by 16 threads", 0.5, 0.9),
    Gate(r"huge, .*, CPU minutes", 10.0, 2.0, is_cost=True),
    Gate(r"huge, .*, GiB of memory", 4.0, is_cost=True),
    Gate(r"scan update over HTTP, 500 poses, besides numerics and commit / FastAPI echo", 1.5, 1.2, is_cost=True),
    Gate(r"first scan update after a start / tenth", 2.0, is_cost=True),
    Gate(r"cluster, two workers / one, critical path", 1.7, 1.9),
    Gate(r"round trip of 4 kB by \w+ / .*, p50", 0.5),
)

GOALS = ((r"prediction, \w+ faces, general poses / embree kernel, windowed beams", 1.0),)
"""Patterns of results that have no gate, and the ratio that is aimed at."""


def gate_of(name: str) -> Gate | None:
    """Return the gate of the result with this name; None if it has none."""
    return next((gate for gate in GATES if re.fullmatch(gate.pattern, name)), None)


def goal_of(name: str) -> float | None:
    """Return the goal of the result with this name, of its gate or without one; None if it has none."""
    gate = gate_of(name)
    if gate is not None:
        return gate.goal
    return next((goal for pattern, goal in GOALS if re.fullmatch(pattern, name)), None)


def missed(results: Sequence[Result]) -> list[str]:
    """Return the names of the results that miss their gate."""
    judged = ((result, gate_of(result.name)) for result in results)
    return [
        result.name
        for result, gate in judged
        if gate is not None and (result.ratio is None or not gate.kept_by(result.ratio))
    ]


def median_of(runs: Sequence[Sequence[Result]]) -> list[Result]:
    """Choose the median result of several whole runs for each name and unit, by ratio, or by our figure without peer.

    Of an even number of runs the worse of the two in the middle is taken where more is better.

    Args:
        runs: each with the same results in the same order.
    """
    return [_median(each) for each in zip(*runs, strict=True)]


def _median(results: Sequence[Result]) -> Result:
    figures = [result.ours if result.ratio is None else result.ratio for result in results]
    return results[figures.index(median_low(figures))]
