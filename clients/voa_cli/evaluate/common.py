"""Options and progress bars that the evaluations share."""

import argparse
import math
from collections.abc import Callable, Iterator
from contextlib import contextmanager

from rich.console import Console
from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeRemainingColumn

from voa_fleet.world.objects import OBJECTS, FleetObject, named_object


@contextmanager
def progress_bar(text: str, total: int) -> Iterator[Callable[[int], None]]:
    """Show a progress bar on stderr, if that is a terminal; yield the function that advances it."""
    console = Console(stderr=True)
    columns = (TextColumn("{task.description}"), BarColumn(), MofNCompleteColumn(), TimeRemainingColumn())
    with Progress(*columns, console=console, transient=True, disable=not console.is_terminal) as progress:
        task = progress.add_task(text, total=total)
        yield lambda count: progress.advance(task, count)


def count(text: str) -> int:
    """Read an option's whole number of at least 1; raises ArgumentTypeError."""
    number = int(text)
    if number < 1:
        raise argparse.ArgumentTypeError(f"expected a number of at least 1, got {text}")
    return number


def amount(text: str) -> float:
    """Read an option's finite number of at least 0; raises ArgumentTypeError."""
    number = float(text)
    if not (math.isfinite(number) and number >= 0.0):
        raise argparse.ArgumentTypeError(f"expected a number of at least 0, got {text}")
    return number


def add_objects(parser: argparse.ArgumentParser) -> None:
    """Add the options that name objects."""
    names = f"{', '.join(OBJECTS)}, or a folder; default: all of the project's own"
    parser.add_argument("objects", nargs="*", metavar="OBJECT", help=names)
    parser.add_argument("--object", nargs="+", default=[], metavar="OBJECT", help="objects, as an option")


def objects_of(options: argparse.Namespace) -> list[FleetObject]:
    """Read the objects that the options name, each once; raises FleetError."""
    return [named_object(name) for name in dict.fromkeys([*options.objects, *options.object] or OBJECTS)]
