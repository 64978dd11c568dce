"""Shrinks the plan of a failing run: fewer operations and less trouble, as long as it fails alike."""

from collections.abc import Callable, Iterator
from dataclasses import fields, replace

from tests.simulation.plan import Plan, Weather
from tests.simulation.run import Result

_MOST_RUNS = 150


def kinds(problems: list[str]) -> set[str]:
    """Return what kinds of problems there are: the part before the first colon."""
    return {problem.partition(":")[0].split(" ")[-1] for problem in problems}


def shrunk(result: Result, run: Callable[[Plan], Result], most_runs: int = _MOST_RUNS) -> Result:
    """Return a result with the smallest plan that was found to have one of the same kinds of problems.

    Args:
        result: of the failing run.
        run: runs a plan.
        most_runs: runs after which the smallest so far has to do.
    """
    wanted, left, progress = kinds(result.problems), most_runs, True
    while progress and left > 0:
        progress = False
        for smaller in _smaller(result.plan):
            if left == 0:
                break
            left -= 1
            tried = run(smaller)
            if wanted & kinds(tried.problems):
                result, progress = tried, True
                break
    return result


def _smaller(plan: Plan) -> Iterator[Plan]:
    """Make simpler plans, the boldest first."""
    if plan.troubles:
        yield plan.without(frozenset(plan.troubles))
    for name in ("crashes", "jumps"):
        if name in plan.troubles:
            yield plan.without(frozenset({name}))
    for client in sorted({each.client for each in plan.operations}):
        yield replace(plan, operations=tuple(each for each in plan.operations if each.client != client))
    size = len(plan.operations) // 2
    while size >= 1:
        for first in range(0, len(plan.operations), size):
            yield replace(plan, operations=plan.operations[:first] + plan.operations[first + size :])
        size //= 2
    for trouble in fields(Weather):
        if getattr(plan.weather, trouble.name):
            yield plan.without(frozenset({trouble.name}))
