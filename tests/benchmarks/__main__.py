"""`python -m tests.benchmarks --out build/bench.json`: run every subject, judge the ratios by their gates, write them.

Ends with 1 if a gate is missed.
"""

import argparse
import importlib.metadata
import json
import os
import platform
import sys
from collections.abc import Callable
from datetime import UTC, datetime
from functools import cache
from pathlib import Path

from rich.box import SIMPLE_HEAD
from rich.console import Console
from rich.table import Table
from threadpoolctl import threadpool_limits

from tests.benchmarks import (
    bus,
    cluster,
    durable,
    growth,
    history,
    huge,
    plots,
    prediction,
    ranking,
    service,
    spread,
    startup,
    weights,
)
from tests.benchmarks.gates import gate_of, goal_of, median_of, missed
from tests.benchmarks.measure import Result

SUBJECTS: dict[str, Callable[[], list[Result]]] = {
    "prediction": prediction.run,
    "weights": weights.run,
    "ranking": ranking.run,
    "spread": spread.run,
    "growth": growth.run,
    "huge": cache(huge.run),  # minutes long: several whole runs have its result in common
    "service": service.run,
    "startup": startup.run,
    "durable": durable.run,
    "bus": bus.run,
    "cluster": cluster.run,
}
_WIDTH = 110  # of the table in a pipe, where rich would guess 80
_PACKAGES = ("numpy", "numba", "trimesh", "embreex")


def main() -> int:
    """Run the subjects, report, and return 0; 1 if a gate is missed."""
    arguments = _arguments()
    console = Console()
    console = console if console.is_terminal else Console(width=_WIDTH)
    when = datetime.now(UTC).strftime("%Y-%m-%d %H:%M UTC")
    console.print(f"{when}; {_machine()}; {_versions()}", highlight=False, soft_wrap=True)
    # OpenBLAS with more threads than free cores waits more than it multiplies.
    with threadpool_limits(1):
        if arguments.plots:
            plots.draw(console)
            return 0
        runs = [_run(console, arguments, turn) for turn in range(arguments.runs)]
    results = median_of(runs)
    if arguments.runs > 1:
        console.print(_table(f"median of {arguments.runs} whole runs", results))
    if arguments.out is not None:
        arguments.out.parent.mkdir(parents=True, exist_ok=True)
        rows = [result._asdict() for result in results]
        arguments.out.write_text(json.dumps(rows, indent=1) + "\n", encoding="utf-8")
    if arguments.keep:
        history.keep(history.run_of(results, when, _machine()))
        history.draw(history.kept())
    failed = missed(results)
    if failed:
        console.print("gates missed:", *failed, sep="\n  ", highlight=False, soft_wrap=True)
    return 1 if failed else 0


def _arguments() -> argparse.Namespace:
    parser = argparse.ArgumentParser(prog="python -m tests.benchmarks", description=__doc__)
    parser.add_argument("--out", type=Path, help="where to write the results as JSON")
    parser.add_argument("--only", choices=SUBJECTS, action="append", help="this subject alone; may be repeated")
    parser.add_argument("--runs", type=int, default=1, help="whole runs; the median of each ratio counts (default: 1)")
    parser.add_argument("--keep", action="store_true", help="add the ratios to the history, and draw it into the docs")
    parser.add_argument("--plots", action="store_true", help="draw how costs grow into the docs instead")
    return parser.parse_args()


def _run(console: Console, arguments: argparse.Namespace, turn: int) -> list[Result]:
    """Run every subject once, with a table of each."""
    results: list[Result] = []
    for name in arguments.only or SUBJECTS:
        with console.status(f"{name}, run {turn + 1} of {arguments.runs}"):
            results_of_subject = SUBJECTS[name]()
        console.print(_table(name, results_of_subject))
        results += results_of_subject
    return results


def _versions() -> str:
    versions = ", ".join(f"{package} {importlib.metadata.version(package)}" for package in _PACKAGES)
    return f"Python {platform.python_version()}, {versions}"


def _machine() -> str:
    return f"{_processor()}, {os.cpu_count()} cores"


def _processor() -> str:
    """The processor's name as Linux reports it, else as Python does."""
    try:
        lines = Path("/proc/cpuinfo").read_text(encoding="utf-8").splitlines()
    except OSError:
        lines = []
    names = [line.partition(":")[2].strip() for line in lines if line.startswith("model name")]
    return names[0] if names else platform.processor() or platform.machine()


def _table(title: str, results: list[Result]) -> Table:
    table = Table(title=title, title_justify="left", box=SIMPLE_HEAD, padding=(0, 1))
    table.add_column("what / against whom")
    for column in ("ratio", "gate", "goal", "ours", "peer"):
        table.add_column(column, justify="right")
    table.add_column("unit")
    for result in results:
        ours, peer = (_figure(figure) for figure in (result.ours, result.peer))
        table.add_row(result.name, *_judged(result), ours, peer, result.unit)
    return table


def _judged(result: Result) -> tuple[str, str, str]:
    """Ratio, gate and goal of a result as they are printed: a missed gate in words, a goal that is reached in green."""
    gate, ratio = gate_of(result.name), _figure(result.ratio)
    goal = goal_of(result.name)
    if result.ratio is None:
        return ratio, "", ""
    if gate is None:
        return (f"[green]{ratio}[/]" if goal is not None and result.ratio >= goal else ratio), "", _figure(goal)
    bound = f"{'at most ' if gate.is_cost else ''}{gate.bound:g}"
    if not gate.kept_by(result.ratio):
        return f"[bold red]{ratio}[/]", f"[bold red]{bound}, missed[/]", _figure(gate.goal)
    reached = gate.reached_by(result.ratio)
    return (f"[green]{ratio}[/]" if reached else ratio), bound, _figure(gate.goal)


def _figure(figure: float | None) -> str:
    return "" if figure is None else f"{figure:.4g}"


if __name__ == "__main__":
    sys.exit(main())
