"""`python -m tests.benchmarks --out build/bench.json`: run every subject, print a table, write the ratios."""

import argparse
import importlib.metadata
import json
import os
import platform
from collections.abc import Callable
from datetime import UTC, datetime
from pathlib import Path

from rich.box import SIMPLE_HEAD
from rich.console import Console
from rich.table import Table
from threadpoolctl import threadpool_limits

from tests.benchmarks import bus, durable, growth, prediction, ranking, service, spread, weights
from tests.benchmarks.measure import Result

SUBJECTS: dict[str, Callable[[], list[Result]]] = {
    "prediction": prediction.run,
    "weights": weights.run,
    "ranking": ranking.run,
    "spread": spread.run,
    "growth": growth.run,
    "service": service.run,
    "durable": durable.run,
    "bus": bus.run,
}
_WIDTH = 110  # of the table in a pipe, where rich would guess 80
_PACKAGES = ("numpy", "numba", "trimesh", "embreex")


def main() -> None:
    """Run the subjects one after another and report."""
    parser = argparse.ArgumentParser(prog="python -m tests.benchmarks", description=__doc__)
    parser.add_argument("--out", type=Path, help="where to write the results as JSON")
    parser.add_argument("--only", choices=SUBJECTS, action="append", help="this subject alone; may be repeated")
    arguments = parser.parse_args()
    console = Console()
    console = console if console.is_terminal else Console(width=_WIDTH)
    console.print(_circumstances(), highlight=False, soft_wrap=True)
    results: list[Result] = []
    # OpenBLAS with more threads than free cores waits more than it multiplies.
    with threadpool_limits(1):
        for name in arguments.only or SUBJECTS:
            with console.status(name):
                results_of_subject = SUBJECTS[name]()
            console.print(_table(name, results_of_subject))
            results += results_of_subject
    if arguments.out is not None:
        arguments.out.parent.mkdir(parents=True, exist_ok=True)
        rows = [result._asdict() for result in results]
        arguments.out.write_text(json.dumps(rows, indent=1) + "\n", encoding="utf-8")


def _circumstances() -> str:
    versions = ", ".join(f"{package} {importlib.metadata.version(package)}" for package in _PACKAGES)
    when = datetime.now(UTC).strftime("%Y-%m-%d %H:%M UTC")
    return f"{when}; {_processor()}, {os.cpu_count()} cores; Python {platform.python_version()}, {versions}"


def _processor() -> str:
    """The processor's name as Linux reports it, else as Python does."""
    try:
        lines = Path("/proc/cpuinfo").read_text(encoding="utf-8").splitlines()
    except OSError:
        lines = []
    names = [line.partition(":")[2].strip() for line in lines if line.startswith("model name")]
    return names[0] if names else platform.processor() or platform.machine()


def _table(subject: str, results: list[Result]) -> Table:
    table = Table(title=subject, title_justify="left", box=SIMPLE_HEAD, padding=(0, 1))
    table.add_column("what / against whom")
    for column in ("ratio", "ours", "peer"):
        table.add_column(column, justify="right")
    table.add_column("unit")
    for result in results:
        figures = ("" if figure is None else f"{figure:.4g}" for figure in (result.ratio, result.ours, result.peer))
        table.add_row(result.name, *figures, result.unit)
    return table


if __name__ == "__main__":
    main()
