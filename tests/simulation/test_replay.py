"""A failure is seen again by its seed: the same steps, byte for byte, in any process; and in a shorter form."""

import os
import subprocess
import sys

from tests.simulation.__main__ import description, search
from tests.simulation.faults import PLANTED
from tests.simulation.plan import plan_of
from tests.simulation.run import Simulator
from tests.simulation.shrink import shrunk

SEEDS = (2, 5, 8)
"""Seeds with trouble of every kind."""
PRINT = (
    "import sys; from tests.simulation.run import Simulator, template; from tests.simulation.plan import plan_of\n"
    "with template() as (database, model):\n"
    "    for seed in map(int, sys.argv[1:]):\n"
    "        print('\\n'.join(Simulator(database, model).run(plan_of(seed)).lines()))\n"
)


def test_a_seed_gives_the_same_steps_in_another_process(simulator: Simulator) -> None:
    seeds = [str(seed) for seed in SEEDS]
    other = subprocess.run(
        [sys.executable, "-c", PRINT, *seeds],
        env=os.environ | {"PYTHONHASHSEED": "12345"},
        capture_output=True,
        text=True,
        check=True,
    ).stdout
    here = [line for seed in SEEDS for line in simulator.run(plan_of(seed)).lines()]
    assert "".join(f"{line}\n" for line in here) == other
    assert len(here) > 10_000


def test_these_seeds_have_trouble_of_every_kind() -> None:
    troubles = {trouble for seed in SEEDS for trouble in plan_of(seed).troubles}
    assert troubles == {"lost", "repeated", "slow", "failed", "stalled", "crashes", "jumps"}


def test_a_failing_plan_is_shrunk_and_says_how_to_see_it_again(simulator: Simulator) -> None:
    name = "expects is not compared"
    (fault,) = (each for each in PLANTED if name in each.name)
    with fault.planted():
        _, result = search(fault, simulator.run)
        assert result is not None
        small = shrunk(result, simulator.run, most_runs=25)
        again = simulator.run(small.plan)
    assert (again.problems, again.trace) == (small.problems, small.trace)
    assert len(small.plan.operations) < len(result.plan.operations) / 4
    text = description(small, name)
    assert small.problems[0] in text
    assert f"python -m tests.simulation --seed {small.plan.seed} --only " in text
    assert not simulator.run(small.plan).problems, "the fault is gone with its patch"
