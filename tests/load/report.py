"""Reports: a table for the terminal, and JSON."""

import json
import os
from collections.abc import Iterable, Mapping
from dataclasses import asdict
from pathlib import Path

from rich.box import MARKDOWN, SIMPLE_HEAD
from rich.table import Table

from tests.load.steps import LATE_MS, Step

_BUSY = 0.93
"""Share of a core, or of all of the machine's, from which on it counts as used up."""


def table(title: str, steps: Iterable[Step]) -> Table:
    """Make a table of the steps of one service."""
    own = Table(title=title, title_justify="left", box=SIMPLE_HEAD, padding=(0, 1))
    for column in ("sessions", "scans/s", "p50 ms", "p99 ms", "CPU ms/scan", "cores", "machine"):
        own.add_column(column, justify="right")
    own.add_column("carried")
    for step in steps:
        cores = step.cores
        own.add_row(
            str(step.sessions),
            f"{step.scans_per_s:.0f}",
            f"{step.p50_ms:.1f}",
            f"{step.p99_ms:.0f}",
            f"{step.cpu_ms_per_scan:.2f}",
            ", ".join(f"{part} {used:.2f}" for part, used in cores.items() if part != "machine"),
            f"{cores['machine']:.2f}",
            step.reason or "yes",
        )
    return own


def summary(measured: Mapping[str, list[Step]]) -> Table:
    """Make a table with the largest number of sessions that each service carries, for a page in Markdown.

    A service that carries not even the first number is shown at that number, with the reason in brackets.
    """
    own = Table(box=MARKDOWN)
    own.add_column("service")
    for column in ("sessions", "scans/s", "p50 ms", "p99 ms", "CPU ms per scan", "cores: service", "machine"):
        own.add_column(column, justify="right")
    for name, steps in measured.items():
        step = ([step for step in steps if step.reason is None] or steps[:1])[-1]
        own.add_row(
            name,
            str(step.sessions) if step.reason is None else f"({step.sessions}: {step.reason})",
            f"{step.scans_per_s:.0f}",
            f"{step.p50_ms:.1f}",
            f"{step.p99_ms:.0f}",
            f"{step.cpu_ms_per_scan:.1f}",
            f"{step.cores['service']:.2f}",
            f"{step.cores['machine']:.2f}",
        )
    return own


def verdict(steps: list[Step], processes: int, cores: int | None = None) -> str:
    """Return what the last step says about the limit of a service, in a sentence.

    Args:
        steps: of the service, with more and more sessions.
        processes: of the service.
        cores: of the machine; None: of this one.
    """
    carried = [step for step in steps if step.reason is None]
    most = max((step.sessions for step in carried), default=0)
    last = steps[-1]
    if last.reason is None:
        return f"carries {most} sessions, and more were not tried"
    if last.reason == "refuses":
        manner = "each with Retry-After" if last.impolite == 0 else f"{last.impolite} without Retry-After"
        answers = ", ".join(f"{count} x {status}" for status, count in sorted(last.refused.items()))
        return f"carries {most} sessions; at {last.sessions} it refuses ({answers}, {manner}): {_causes(last)}"
    late = f"p99 exceeds {LATE_MS:.0f} ms" if last.reason == "late" else "scans are behind"
    return (
        f"carries {most} sessions; at {last.sessions} {late}: {_binding(last, processes, cores or os.cpu_count() or 1)}"
    )


def _causes(step: Step) -> str:
    return "; ".join(f"{kind}: {detail}" for kind, detail in sorted(step.causes.items())) or "no reason is given"


def _binding(step: Step, processes: int, cores: int) -> str:
    used = step.cores
    if used["service"] >= _BUSY * processes:
        return f"{processes} core(s) of Python for {processes} process(es) are used up"
    if used["machine"] >= _BUSY * cores:
        others = used["machine"] - sum(own for part, own in used.items() if part != "machine")
        parts = ", ".join(f"{part} {own:.2f}" for part, own in used.items() if part != "machine")
        return f"the {cores} cores of the machine are used up ({parts}, other programs {others:.2f})"
    return "it waits, and not for a processor"


def write(file: Path, measured: Mapping[str, list[Step]], **circumstances: object) -> None:
    """Write all steps as JSON, with what a reader must know about the run."""
    rows = {
        name: [
            asdict(step)
            | {"scans_per_s": step.scans_per_s, "cpu_ms_per_scan": step.cpu_ms_per_scan, "reason": step.reason}
            for step in steps
        ]
        for name, steps in measured.items()
    }
    file.parent.mkdir(parents=True, exist_ok=True)
    file.write_text(json.dumps({**circumstances, "services": rows}, indent=1) + "\n", encoding="utf-8")
