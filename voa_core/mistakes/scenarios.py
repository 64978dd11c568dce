"""Mistakes of a whole scenario: every check, with a bound on what it may cost."""

from voa_core.mistakes.found import Mistake
from voa_core.mistakes.heights import mistakes_of_heights
from voa_core.mistakes.places import mistakes_of_places
from voa_core.mistakes.twins import mistakes_of_twins
from voa_core.mistakes.values import mistakes_of_values
from voa_core.objects import Object
from voa_core.scenario import Scenario

MOST_PAIRS = 2000
"""Pairs of pose and place that are looked at where a look over all of them would take too long."""


def mistakes_of_scenario(
    scenario: Scenario, object_: Object | None, most_pairs: int | None = MOST_PAIRS
) -> tuple[Mistake, ...]:
    """Find what is probably wrong with a scenario.

    Args:
        scenario: to look at.
        object_: its mesh; None where all predictions are data.
        most_pairs: pairs of pose and place to look at; beyond it a regular selection of the poses and places stands
            for all, and nothing is said that the selection does not show. None: all.

    Returns:
        At most one mistake of each kind, but one for each group of twin poses.
    """
    found = mistakes_of_values(scenario)
    if object_ is not None and scenario.poses.rotations is not None:
        found += mistakes_of_heights(scenario.poses, object_, most_pairs)
        found += mistakes_of_twins(scenario.poses, scenario.table, object_, most_pairs)
    return tuple(found + mistakes_of_places(scenario, object_, most_pairs))
