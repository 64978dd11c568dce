"""Printing of the service's warnings for a person at a terminal."""

from collections.abc import Sequence
from textwrap import fill, indent

from rich.console import Console

from voa_msgs.warnings import ProbableMistake

_INDENT = "  "


def print_warnings(console: Console, warnings: Sequence[ProbableMistake]) -> None:
    """Print a paragraph for each warning: its kind, then its explanation."""
    for warning in warnings:
        console.print(f"warning: {warning.kind}", style="yellow")
        console.print(indent(fill(warning.detail, console.width - len(_INDENT)), _INDENT), soft_wrap=True)
