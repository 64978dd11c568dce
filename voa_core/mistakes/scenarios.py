"""Mistakes of a whole scenario: every check, with a bound on what it may cost."""

from voa_core.mistakes.effort import Effort
from voa_core.mistakes.heights import Mesh, mistakes_of_heights
from voa_core.mistakes.mistake import Mistake
from voa_core.mistakes.places import mistakes_of_places
from voa_core.mistakes.twins import mistakes_of_twins
from voa_core.mistakes.values import mistakes_of_values
from voa_core.scenario import Scenario


def mistakes_of_scenario(scenario: Scenario, mesh: Mesh | None, effort: Effort) -> tuple[Mistake, ...]:
    """Find what is probably wrong with a scenario.

    Args:
        scenario: to look at.
        mesh: its object; None where all predictions are data.
        effort: how much work the search may be.

    Returns:
        One mistake for each kind of slip that shows; one for each group of twin poses, and for each scan plane that
        misses a pose.
    """
    found = mistakes_of_values(scenario)
    if mesh is not None:
        found += mistakes_of_heights(scenario.poses, mesh, effort)
        found += mistakes_of_twins(scenario.poses, scenario.table, mesh.object_, effort)
    return tuple(found + mistakes_of_places(scenario, None if mesh is None else mesh.object_, effort))
