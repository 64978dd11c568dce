"""Run the simulation: seeds until one fails, or one seed again.

python -m tests.simulation --writes 100000      as many seeds as make so many writes; --processes 2 shares them
python -m tests.simulation --seed 7             one seed; where it fails, its shortest form and last steps
python -m tests.simulation --planted            each planted fault, with the number of seeds until it is found
"""

import argparse
import subprocess
import sys
import time
from collections.abc import Callable
from contextlib import nullcontext

from rich.console import Console
from rich.table import Table

from tests.simulation.faults import PLANTED, PlantedFault
from tests.simulation.plan import OPERATIONS, Plan, plan_of
from tests.simulation.run import Result, Simulator, template
from tests.simulation.shrink import shrunk

_LAST_STEPS = 60
_REPORT_EVERY_SECONDS = 60.0
_SEEDS_OF_PROCESS = 1_000_000


def main(arguments: list[str]) -> int:
    """Run what the arguments say; returns the number of failing seeds, or of planted faults that stay unnoticed."""
    options = _options(arguments)
    if options.processes > 1:
        return _shared(options.first, options.writes, options.processes, options.fault)
    with template() as (database, model):
        run = Simulator(database, model).run
        if options.planted:
            return _planted(run)
        fault = next((each for each in PLANTED if options.fault and options.fault in each.name), None)
        if options.fault and fault is None:
            print(f"no planted fault has {options.fault!r} in its name: see --planted", file=sys.stderr)
            return 1
        with nullcontext() if fault is None else fault.planted():
            if options.seed is not None:
                plan = plan_of(options.seed).without(frozenset(options.without))
                return _one(plan if options.only is None else plan.only(frozenset(options.only)), run, options.fault)
            return _many(options.first, options.writes, run, options.fault)


def _options(arguments: list[str]) -> argparse.Namespace:
    def numbers(text: str) -> list[int]:
        return [int(number) for number in text.split(",")]

    parser = argparse.ArgumentParser(prog="python -m tests.simulation", description=__doc__)
    parser.add_argument("--writes", type=int, default=100_000, help="run seeds until they have made so many writes")
    parser.add_argument("--processes", type=int, default=1, help="share the writes among so many processes")
    parser.add_argument("--first", type=int, default=0, help="seed to begin with")
    parser.add_argument("--seed", type=int, help="run this seed alone")
    parser.add_argument("--only", type=numbers, help="numbers of the only operations of the seed, with commas")
    parser.add_argument("--without", type=lambda text: text.split(","), default=[], help="troubles to leave out")
    parser.add_argument("--fault", help="plant the fault whose name has this text")
    parser.add_argument("--planted", action="store_true", help="search for each planted fault")
    return parser.parse_args(arguments)


def _one(plan: Plan, run: Callable[[Plan], Result], fault: str | None) -> int:
    """Run one plan; where it fails, shrink it, and print how to see that again."""
    result = run(plan)
    if result.problems:
        result = shrunk(result, run)
        print(description(result, fault))
    else:
        print(f"seed {plan.seed}: {result.writes} writes, {len(result.trace)} steps, nothing wrong")
    return int(bool(result.problems))


def _many(first: int, writes: int, run: Callable[[Plan], Result], fault: str | None) -> int:
    """Run seeds until they have made so many writes, and stop at the first that fails."""
    made = versions = 0
    began = reported = time.monotonic()
    seed = first
    while made < writes:
        result = run(plan_of(seed))
        if result.problems:
            return _one(result.plan, run, fault)
        made, versions, seed = made + result.writes, versions + result.versions, seed + 1
        if time.monotonic() - reported > _REPORT_EVERY_SECONDS:
            reported = time.monotonic()
            print(f"{made} writes of {writes}, {seed - first} seeds", file=sys.stderr, flush=True)
    print(
        f"{made} writes in {seed - first} seeds from {first} on, {versions} versions kept to the end, nothing wrong, "
        f"in {time.monotonic() - began:.0f} s ({time.process_time():.0f} s of CPU)"
    )
    return 0


def _shared(first: int, writes: int, processes: int, fault: str | None) -> int:
    """Run seeds in several processes, each with seeds of its own; returns the number of processes that failed."""
    command = [sys.executable, "-m", "tests.simulation", "--writes", str(-(-writes // processes))]
    command += [] if fault is None else ["--fault", fault]
    firsts = [str(first + number * _SEEDS_OF_PROCESS) for number in range(processes)]
    running = [subprocess.Popen([*command, "--first", each]) for each in firsts]
    return sum(process.wait() != 0 for process in running)


def _planted(run: Callable[[Plan], Result]) -> int:
    """Search for each planted fault; returns the number of those that were not found."""
    table = Table("fault", "seeds until found", "problem", "operations", "troubles", title="Planted faults")
    missed = 0
    for fault in PLANTED:
        with fault.planted():
            seeds, result = search(fault, run)
            if result is None:
                missed += 1
                table.add_row(fault.name, f"not within {seeds}", "", "", "")
                continue
            small = shrunk(result, run)
        print(f"{fault.name}: seed {result.plan.seed}", file=sys.stderr, flush=True)
        troubles = ", ".join(small.plan.troubles) or "none"
        table.add_row(fault.name, str(seeds), small.problems[0][:160], str(len(small.plan.operations)), troubles)
    Console(width=200).print(table)
    return missed


def search(
    fault: PlantedFault, run: Callable[[Plan], Result], operations: int = OPERATIONS, first: int = 0
) -> tuple[int, Result | None]:
    """Run seeds until a planted fault is found; returns how many, and the failing run; None: none failed.

    Args:
        fault: that is planted already.
        run: runs a plan.
        operations: of each client.
        first: seed that is tried before the others.
    """
    assert first < fault.seeds
    for tried, seed in enumerate(sorted(range(fault.seeds), key=lambda seed: seed != first), start=1):
        result = run(plan_of(seed, operations))
        if result.problems:
            return tried, result
    return fault.seeds, None


def description(result: Result, fault: str | None = None) -> str:
    """Describe a failing run: its problems, its last steps, and the command that runs it again."""
    plan = result.plan
    left_out = [name for name in plan_of(plan.seed).troubles if name not in plan.troubles]
    options = [f"--seed {plan.seed}"]
    if len(plan.operations) < len(plan_of(plan.seed).operations):
        options.append(f"--only {','.join(str(each.number) for each in plan.operations) or '-1'}")
    if left_out:
        options.append(f"--without {','.join(left_out)}")
    if fault is not None:
        options.append(f"--fault {fault!r}")
    troubles = ", ".join(plan.troubles) or "none"
    parts = [
        f"seed {plan.seed} fails with {len(plan.operations)} operations and troubles: {troubles}",
        *(f"  {problem}" for problem in result.problems[:10]),
        "last steps (time, task, what comes next):",
        *result.last_lines(_LAST_STEPS),
        "again:",
        f"  python -m tests.simulation {' '.join(options)}",
    ]
    return "\n".join(parts)


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
