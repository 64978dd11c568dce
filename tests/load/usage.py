"""CPU time of processes with all that they started, and of the machine."""

import os
from collections.abc import Iterable
from contextlib import suppress
from pathlib import Path

_TICKS = os.sysconf("SC_CLK_TCK")


def cpu_seconds(pids: Iterable[int]) -> float:
    """Return the CPU time of processes and their children so far, user and system, those that have ended included."""
    return sum(_of(pid) for pid in pids)


def machine_seconds() -> float:
    """Return the time for which the machine's processors were busy so far, whatever with."""
    user, nice, system, _, _, irq, softirq, *_ = Path("/proc/stat").read_text(encoding="utf-8").split()[1:9]
    return sum(int(ticks) for ticks in (user, nice, system, irq, softirq)) / _TICKS


def _of(pid: int) -> float:
    fields = Path(f"/proc/{pid}/stat").read_text(encoding="utf-8").rpartition(")")[2].split()
    own = sum(int(field) for field in fields[11:15])  # the last two: children that have ended
    children = 0.0
    for thread in Path(f"/proc/{pid}/task").iterdir():
        with suppress(FileNotFoundError):  # a child may end in between; its time is its parent's from then on
            children += cpu_seconds(int(child) for child in (thread / "children").read_text().split())
    return own / _TICKS + children
