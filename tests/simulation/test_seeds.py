"""Random histories of the production's use cases and store: nothing answered is lost, or happens twice.

A few of the writes that `.ci/run` and `make chaos` make with `python -m tests.simulation`, for as many as are wanted.
"""

import pytest

from tests.simulation.__main__ import description, main
from tests.simulation.plan import plan_of
from tests.simulation.run import Simulator
from tests.simulation.shrink import shrunk
from tests.support.scale import scaled

CHUNKS = 4
WRITES = scaled(4_000, 100_000) // CHUNKS


@pytest.mark.parametrize("chunk", range(CHUNKS))
def test_no_seed_finds_a_fault(simulator: Simulator, chunk: int) -> None:
    seed, writes = 100_000 * chunk, 0
    while writes < WRITES:
        result = simulator.run(plan_of(seed))
        assert not result.problems, description(shrunk(result, simulator.run))
        seed, writes = seed + 1, writes + result.writes


def test_each_process_that_shares_the_writes_may_fail() -> None:
    assert main(["--writes", "2", "--processes", "2", "--fault", "no such fault"]) == 2
