"""Warnings of the service, as a person reads them."""

from collections.abc import Sequence

from rich.console import Console
from rich.padding import Padding

from voa_msgs.warnings import ProbableMistake


def print_warnings(console: Console, warnings: Sequence[ProbableMistake]) -> None:
    """Print one paragraph for each warning: its kind, then its sentence."""
    for warning in warnings:
        console.print(f"warning: {warning.kind}", style="yellow")
        console.print(Padding(warning.detail, (0, 0, 0, 2)))
