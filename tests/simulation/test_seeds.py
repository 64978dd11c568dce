"""Random histories of the production's use cases and store: nothing answered is lost, or happens twice.

CI makes a part of the writes that `make chaos` makes; see `tests.simulation.__main__` for as many as are wanted.
"""

import pytest

from tests.simulation.__main__ import description
from tests.simulation.plan import plan_of
from tests.simulation.run import Simulator
from tests.simulation.shrink import shrunk
from tests.support.scale import scaled

CHUNKS = 4
WRITES = scaled(16_000, 100_000) // CHUNKS


@pytest.mark.parametrize("chunk", range(CHUNKS))
def test_no_seed_finds_a_fault(simulator: Simulator, chunk: int) -> None:
    seed, writes = 100_000 * chunk, 0
    while writes < WRITES:
        result = simulator.run(plan_of(seed))
        assert not result.problems, description(shrunk(result, simulator.run))
        seed, writes = seed + 1, writes + result.writes
