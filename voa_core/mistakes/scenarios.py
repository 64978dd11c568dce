"""Mistakes of a whole scenario: all checks, within a limit of their work."""

from voa_core.mistakes.effort import Effort
from voa_core.mistakes.heights import Mesh, mistakes_of_heights
from voa_core.mistakes.mistake import Mistake
from voa_core.mistakes.places import mistakes_of_places
from voa_core.mistakes.twins import mistakes_of_twins
from voa_core.mistakes.values import mistakes_of_values
from voa_core.scenario import Scenario


def mistakes_of_scenario(scenario: Scenario, mesh: Mesh | None, effort: Effort) -> tuple[Mistake, ...]:
    """Find the probable mistakes in a scenario.

    Args:
        scenario: the scenario to search.
        mesh: its object; None where all predictions are data.
        effort: limits of the search.

    Returns:
        One mistake of each kind that occurs; one for each group of twin poses, and for each scan plane that
        misses a pose.
    """
    mistakes = mistakes_of_values(scenario)
    if mesh is not None:
        mistakes += mistakes_of_heights(scenario.poses, mesh, effort)
        mistakes += mistakes_of_twins(scenario.poses, scenario.table, mesh.object_, effort)
    return tuple(mistakes + mistakes_of_places(scenario, None if mesh is None else mesh.object_, effort))
