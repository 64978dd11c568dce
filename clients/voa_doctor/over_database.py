"""Check of a database: all checksums, by the service's own program in a process."""

import json
import subprocess
import sys
from collections.abc import Callable, Iterator

from pydantic import BaseModel

from voa_doctor.findings import Finding

Verify = Callable[[str], str]
"""Function that verifies the database at a URL, and returns the JSON of `voa_store.verify`."""

_CHECK = "database"
_MOST_LISTED = 5
_RESTORE = "check the disk, and restore a backup; a damaged session can be deleted, the others work"


class DamagedSession(BaseModel):
    """A session of which a version is damaged or missing.

    Attributes:
        session: its id.
        version: the first such version; -1: it is not known.
    """

    session: str
    version: int


class DatabaseReport(BaseModel):
    """Result of verifying a database, as `python -m voa_store.verify` prints it.

    Attributes:
        error: why the database cannot be read; None: it was read, and the other fields are filled in.
        database: name and version of the database's software.
        sessions: number of sessions that were read.
        versions: number of undamaged versions of these sessions.
        damaged: sessions that differ from what was written.
        pages: faults that SQLite reports in the structure of its file.
        objects: ids of damaged meshes.
    """

    error: str | None = None
    database: str = ""
    sessions: int = 0
    versions: int = 0
    damaged: list[DamagedSession] = []
    pages: list[str] = []
    objects: list[str] = []


def verify_in_process(url: str) -> str:
    """Verify a database by `python -m voa_store.verify`, which reads the URL, maybe with a password, from stdin."""
    command = [sys.executable, "-m", "voa_store.verify", "-"]
    done = subprocess.run(command, input=url, capture_output=True, text=True, check=False)  # noqa: S603 - our own module
    return done.stdout or json.dumps({"error": done.stderr.strip().rpartition("\n")[2] or "the check did not run"})


def check_database(url: str, verify: Verify = verify_in_process) -> Iterator[Finding]:
    """Verify every version of every session of a database, however long it takes.

    Args:
        url: of the database, as for `voa serve --database-url`.
        verify: verifies it.
    """
    report = DatabaseReport.model_validate_json(verify(url))
    if report.error is not None:
        yield Finding(_CHECK, "wrong", report.error, "give --database-url the same URL as `voa serve`")
        return
    for line in report.pages[:_MOST_LISTED]:
        yield Finding(_CHECK, "wrong", f"the file's structure is damaged: {line}", _RESTORE)
    for id_ in report.objects[:_MOST_LISTED]:
        yield Finding(_CHECK, "wrong", f"object {id_}: the stored mesh was changed after it was written", _RESTORE)
    for damage in report.damaged[:_MOST_LISTED]:
        seen = f"session {damage.session}: the stored version {damage.version} was changed after it was written"
        yield Finding(_CHECK, "wrong", seen, _RESTORE)
    if len(report.damaged) > _MOST_LISTED:
        yield Finding(_CHECK, "wrong", f"{len(report.damaged)} sessions are damaged in total", _RESTORE)
    if not (report.pages or report.damaged or report.objects):
        seen = f"{report.database}: {report.versions} versions of {report.sessions} sessions, all checksums match"
        yield Finding(_CHECK, "ok", seen)
