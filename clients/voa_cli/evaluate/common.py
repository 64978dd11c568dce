"""What the commands share."""

import argparse
import math
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Any

from rich.console import Console
from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeRemainingColumn

from voa_fleet.world.objects import OBJECTS, FleetObject, named_object


@contextmanager
def progress_bar(what: str, total: int) -> Iterator[Callable[[int], None]]:
    """A progress bar on a terminal, on stderr; nothing in a pipe. Gives the function that advances it."""
    console = Console(stderr=True)
    columns = (TextColumn("{task.description}"), BarColumn(), MofNCompleteColumn(), TimeRemainingColumn())
    with Progress(*columns, console=console, transient=True, disable=not console.is_terminal) as progress:
        task = progress.add_task(what, total=total)
        yield lambda count: progress.advance(task, count)


def count(text: str) -> int:
    """An option's number of at least 1; raises ArgumentTypeError."""
    number = int(text)
    if number < 1:
        raise argparse.ArgumentTypeError(f"expected a number of at least 1, got {text}")
    return number


def amount(text: str) -> float:
    """An option's finite number of at least 0; raises ArgumentTypeError."""
    number = float(text)
    if not (math.isfinite(number) and number >= 0.0):
        raise argparse.ArgumentTypeError(f"expected a number of at least 0, got {text}")
    return number


def add_objects(parser: argparse.ArgumentParser) -> None:
    """The options that say which objects."""
    told = f"{', '.join(OBJECTS)}, or a folder; default: all of the project's own"
    parser.add_argument("objects", nargs="*", metavar="OBJECT", help=told)
    parser.add_argument("--object", nargs="+", default=[], metavar="OBJECT", help="the same")


def objects_of(options: argparse.Namespace) -> list[FleetObject]:
    """The objects that the options name, each once; raises FleetError."""
    return [named_object(name) for name in dict.fromkeys([*options.objects, *options.object] or OBJECTS)]


def one_or_all(documents: list[dict[str, Any]]) -> dict[str, Any]:
    """What `--json` prints: the document of the only object, or `objects` with all of them."""
    return documents[0] if len(documents) == 1 else {"objects": documents}
