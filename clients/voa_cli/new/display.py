"""Display of `voa new`: its steps while they run, and its result."""

from collections.abc import Iterator
from contextlib import contextmanager
from shlex import quote
from textwrap import fill

from rich.console import Console
from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeElapsedColumn

from voa_cli.tables import ranking_table
from voa_cli.warnings import print_warnings
from voa_msgs.base import Message
from voa_msgs.rankings import Ranking
from voa_msgs.warnings import ProbableMistake
from voa_setup.choices import GEOMETRIC
from voa_setup.setup import NewScenario


class NewScenarioReport(Message):
    """Result of `voa new` as JSON."""

    folder: str
    """Folder with the files."""
    page: str
    """Page that shows whether the scenario is right."""
    poses: list[str]
    """Names of the poses."""
    grasps: list[str]
    """Names of the grasps."""
    places: list[str]
    """Names of the sensor configurations."""
    notes: list[str]
    """Sentences about what was decided, merged, left out or guessed."""
    warnings: list[ProbableMistake]
    """Probable mistakes; empty: none was detected."""
    ranking: Ranking
    """Ranking of the places under the prior."""


class Terminal:
    """Steps of the command on stderr: a bar at a terminal, nothing in a pipe."""

    def __init__(self, progress: Progress) -> None:
        self._progress = progress
        self._task = progress.add_task("", total=None)

    def begin(self, text: str) -> None:
        """Show that a step begins."""
        self._progress.update(self._task, description=text, completed=0, total=None)

    def advance(self, done: int, total: int) -> None:
        """Show how many parts of the current step are finished."""
        self._progress.update(self._task, completed=done, total=total)


@contextmanager
def terminal() -> Iterator[Terminal]:
    """Show the steps on stderr for the length of a `with`, if that is a terminal."""
    console = Console(stderr=True)
    columns = (TextColumn("{task.description}"), BarColumn(), MofNCompleteColumn(), TimeElapsedColumn())
    with Progress(*columns, console=console, transient=True, disable=not console.is_terminal) as progress:
        yield Terminal(progress)


def report_of(result: NewScenario) -> NewScenarioReport:
    """Summarise the result for `--json`."""
    scenario = result.scenario
    return NewScenarioReport(
        folder=str(result.folder),
        page=str(result.page),
        poses=[pose.name for pose in scenario.poses],
        grasps=[grasp.name for grasp in scenario.grasps],
        places=[place.name for place in scenario.sensors],
        notes=result.notes,
        warnings=result.warnings,
        ranking=result.ranking,
    )


def print_result(result: NewScenario, scores: str) -> None:
    """Print notes, warnings and the ranking, and three lines about what to do next."""
    console = Console(markup=False, highlight=False)
    scenario = result.scenario
    for note in result.notes:
        console.print(fill(f"- {note}", console.width, subsequent_indent="  "), soft_wrap=True)
    print_warnings(console, result.warnings)
    numbers = {"pose": len(scenario.poses), "grasp": len(scenario.grasps), "place": len(scenario.sensors)}
    counts = ", ".join(f"{number} {noun}{'' if number == 1 else 's'}" for noun, number in numbers.items())
    console.print(f"\n{result.folder}: {counts}", style="bold", soft_wrap=True)
    ranking = result.ranking
    best = ranking.best_grasp_before or "none"
    console.print(f"best grasp without a look: {best}, expected score {ranking.expected_score_before:.2f}")
    console.print(ranking_table(console, ranking))
    console.print("\nNext:", style="bold")
    for number, line in enumerate(next_steps(result, scores), 1):
        console.print(f"{number}. {line}", soft_wrap=True)


def next_steps(result: NewScenario, scores: str) -> list[str]:
    """Say in three lines what to do with the folder."""
    folder = quote(str(result.folder))
    measured = f"measure your own scores: fill {folder}/scores.csv, and repeat the command with --scores FILE --force"
    if scores == GEOMETRIC:
        measured = "repeat the command with --scores simulated --force: scores from the shapes alone are a first guess"
    return [
        f"open {folder}/{result.page.name}: do the rests, grasps and places look right?",
        f"voa demo --object {folder}: simulated robots look and grasp",
        measured,
    ]
