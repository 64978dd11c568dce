"""A map over the parts of a ranking that reports how many of them are finished."""

from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass
from typing import TypeVar

from voa_service.mapping.rankings import ParallelMap

A = TypeVar("A")
B = TypeVar("B")

Report = Callable[[int, int], None]
"""A function that is called with the number of finished parts and the number of all parts."""


@dataclass(frozen=True)
class ReportedMap:
    """A `map` that works as another one does, and reports each result.

    Attributes:
        parallel_map: applies the function to the items.
        report: called for each result in its turn.
    """

    parallel_map: ParallelMap
    report: Report

    def __call__(self, function: Callable[[A], B], items: Iterable[A], /) -> Iterator[B]:
        """Yield the results in the order of the items."""
        listed = list(items)
        for done, result in enumerate(self.parallel_map(function, listed), start=1):
            self.report(done, len(listed))
            yield result
