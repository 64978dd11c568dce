"""Attacks on all writes: 100 000 of them on each database, under kills, faults and cuts; their history is checked."""

import os
import sys
from functools import partial
from pathlib import Path

from tests.chaos.attack import Attack, Outcome
from tests.support.history_chaos import Plan, endure

WRITES = int(os.environ.get("CHAOS_WRITES", "100000"))
"""Number of writes that must be answered on each database."""


def writes_under_everything(kind: str, folder: Path) -> Outcome:
    """Write until so many writes are answered, and check every call against the stored history."""
    plan = Plan(WRITES, writers=16, sessions=max(4, WRITES // 500), events=max(8, WRITES // 500))
    endured = endure(kind, folder, plan, lambda line: print(f"  {kind}, {line}", file=sys.stderr, flush=True))
    return Outcome("0 lost, 0 twice, 0 out of order", str(endured), endured.answered >= WRITES)


ATTACKS = [
    Attack(
        f"writes: {WRITES} on {name}, under kills, faults and cuts",
        "kills alone, 6 000 writes",
        "0 lost, 0 twice",
        partial(writes_under_everything, kind),
    )
    for kind, name in (("sqlite", "SQLite"), ("postgresql", "PostgreSQL"))
]
