"""History of the ratios: the runs that are worth keeping, a line each, and their picture in the documentation."""

import json
import subprocess
from collections.abc import Sequence
from dataclasses import asdict, dataclass
from pathlib import Path

from matplotlib import rc_context
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure

from tests.benchmarks.gates import gate_of
from tests.benchmarks.measure import Result

REPOSITORY = Path(__file__).parents[2]
HISTORY = Path(__file__).with_name("history.jsonl")
PICTURE = REPOSITORY / "deploy" / "docs" / "pictures" / "speed-history.svg"

_INK, _MISSED, _KEPT, _GOAL = "#444444", "#D55E00", "#0072B2", "#009E73"


@dataclass(frozen=True)
class Run:
    """Run of the benchmarks.

    Attributes:
        commit: that was measured, with "+" where the files differed from it.
        when: time in UTC.
        machine: processor and number of cores.
        ratios: of each result that has a gate.
    """

    commit: str
    when: str
    machine: str
    ratios: dict[str, float]


def run_of(results: Sequence[Result], when: str, machine: str) -> Run:
    """Make the record of a run from its results."""
    return Run(
        _commit(),
        when,
        machine,
        {each.name: round(each.ratio, 3) for each in results if each.ratio is not None and gate_of(each.name)},
    )


def keep(run: Run, path: Path = HISTORY) -> None:
    """Append a run to the history file."""
    with path.open("a", encoding="utf-8") as file:
        file.write(json.dumps(asdict(run), separators=(",", ":")) + "\n")


def kept(path: Path = HISTORY) -> list[Run]:
    """Read the history file, the oldest run first."""
    if not path.exists():
        return []
    return [Run(**json.loads(line)) for line in path.read_text(encoding="utf-8").splitlines()]


def draw(runs: Sequence[Run], path: Path = PICTURE) -> None:
    """Draw by which factor each ratio was better than its gate, the newest run dark, earlier ones pale, as SVG."""
    names = list(dict.fromkeys(name for run in reversed(runs) for name in run.ratios if gate_of(name)))
    with rc_context({"svg.hashsalt": "voa", "font.size": 8}):
        figure = Figure(figsize=(8.0, 0.6 + 0.22 * len(names)), layout="constrained")
        FigureCanvasAgg(figure)
        axes = figure.add_subplot()
        for age, run in enumerate(reversed(runs)):
            _draw_run(axes, run, names, alpha=1.0 if age == 0 else 0.25)
        _draw_goals(axes, names)
        axes.axvline(1.0, color=_INK, linewidth=1.0)
        axes.set_xscale("log", base=2)
        axes.set_xticks([0.5, 1, 2, 4], ["0.5 x", "gate", "2 x", "4 x"])
        axes.set_yticks(range(len(names)), names)
        axes.invert_yaxis()
        axes.grid(axis="x", alpha=0.3)
        figure.savefig(path, format="svg", metadata={"Date": None})


def _draw_run(axes: Axes, run: Run, names: Sequence[str], alpha: float) -> None:
    for row, name in enumerate(names):
        gate, ratio = gate_of(name), run.ratios.get(name)
        if gate is not None and ratio is not None:
            colour = _KEPT if gate.kept_by(ratio) else _MISSED
            axes.plot(gate.margin(ratio), row, "o" if gate.kept_by(ratio) else "X", color=colour, alpha=alpha)


def _draw_goals(axes: Axes, names: Sequence[str]) -> None:
    for row, name in enumerate(names):
        gate = gate_of(name)
        if gate is not None and gate.goal is not None:
            axes.plot(gate.margin(gate.goal), row, "|", color=_GOAL, markersize=10)


def _commit() -> str:
    def git(*arguments: str) -> str:
        return subprocess.run(["git", *arguments], cwd=REPOSITORY, capture_output=True, text=True, check=True).stdout

    changed = git("status", "--porcelain", "--untracked-files=no").strip()
    return git("rev-parse", "--short", "HEAD").strip() + ("+" if changed else "")
