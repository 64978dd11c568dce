"""Each planted fault is found within few seeds, and seen again by its seed."""

import pytest

from tests.simulation.__main__ import search
from tests.simulation.faults import PLANTED, Change, PlantedFault
from tests.simulation.run import Simulator

OPERATIONS = 30
"""Operations of each client: short runs, so that all faults fit into the time of CI."""


@pytest.mark.parametrize("fault", [each for each in PLANTED if not each.rare], ids=lambda fault: fault.name)
def test_a_planted_fault_is_detected_and_replayed(simulator: Simulator, fault: PlantedFault) -> None:
    with fault.planted():
        seeds, first = search(fault, simulator.run, OPERATIONS, fault.first)
        assert first is not None, f"not found within {seeds} seeds"
        again = simulator.run(first.plan)
    assert (again.problems, again.trace) == (first.problems, first.trace)


@pytest.mark.parametrize("fault", [each for each in PLANTED if each.rare], ids=lambda fault: fault.name)
def test_the_texts_that_a_rare_fault_replaces_are_there(fault: PlantedFault) -> None:
    assert all(change.code() != change.function().__code__ for change in fault.changes)


def test_a_text_that_is_gone_is_an_error() -> None:
    change = Change("voa_store.changing:check_version", (("no such text", ""),))
    with pytest.raises(ValueError, match="once"):
        change.code()
