"""Whether everything in a database is as it was written; the service's own program reads it, in a process."""

import json
import subprocess
import sys
from collections.abc import Callable, Iterator
from typing import Any

from voa_cli.doctor.findings import Finding

Verify = Callable[[str], str]
"""Reads a database and returns what was found, as the JSON of `voa_store.verify`."""

_CHECK = "database"
_MOST_LISTED = 5
_RESTORE = "check the disk, and restore a backup; a damaged session can be deleted, the others work"


def verify_in_process(url: str) -> str:
    """Verify a database by `python -m voa_store.verify`; the URL, which may hold a password, goes by stdin."""
    command = [sys.executable, "-m", "voa_store.verify", "-"]
    done = subprocess.run(command, input=url, capture_output=True, text=True, check=False)  # noqa: S603 - ours
    return done.stdout or json.dumps({"error": done.stderr.strip().rpartition("\n")[2] or "the check did not run"})


def check_database(url: str, verify: Verify = verify_in_process) -> Iterator[Finding]:
    """Verify every version of every session of a database, however long it takes.

    Args:
        url: of the database, as the service takes it.
        verify: reads it.
    """
    found: dict[str, Any] = json.loads(verify(url))
    if "error" in found:
        yield Finding(_CHECK, "wrong", found["error"], "voa doctor --database-url takes the URL that the service takes")
        return
    for line in found["pages"][:_MOST_LISTED]:
        yield Finding(_CHECK, "wrong", f"the file's structure is damaged: {line}", _RESTORE)
    for damage in found["damaged"][:_MOST_LISTED]:
        seen = f"session {damage['session']}: version {damage['version']} is not as it was written"
        yield Finding(_CHECK, "wrong", seen, _RESTORE)
    if len(found["damaged"]) > _MOST_LISTED:
        yield Finding(_CHECK, "wrong", f"{len(found['damaged'])} sessions are damaged in all", _RESTORE)
    if not found["pages"] and not found["damaged"]:
        seen = f"{found['database']}: {found['versions']} versions of {found['sessions']} sessions, all checksums right"
        yield Finding(_CHECK, "ok", seen)
