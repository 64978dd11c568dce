"""`voa doctor --database-url`: every version of a database is verified, and what is damaged is named."""

import json
from pathlib import Path
from typing import Any

import pytest

from tests.support.serving import data_scenario, scan_of, serving
from voa_cli.doctor import main
from voa_doctor.findings import Finding
from voa_doctor.over_database import check_database
from voa_store.drivers import sqlite_driver

RIGHT: dict[str, Any] = {"database": "SQLite 3.53.4", "sessions": 2, "versions": 7, "damaged": [], "pages": []}


def findings(**result: Any) -> list[Finding]:
    return list(check_database("sqlite:///voa.db", lambda _url: json.dumps(result)))


def test_a_database_in_order_is_one_line() -> None:
    (finding,) = findings(**RIGHT)
    assert finding.state == "ok"
    assert finding.seen == "SQLite 3.53.4: 7 versions of 2 sessions, all checksums match"


def test_what_is_damaged_is_named_and_no_more_than_five() -> None:
    damaged = [{"session": f"s{n}", "version": n, "detail": ""} for n in range(7)]
    result = findings(**RIGHT | {"damaged": damaged, "pages": ["row 3 missing from index"]})
    assert {finding.state for finding in result} == {"wrong"}
    assert result[0].seen == "the file's structure is damaged: row 3 missing from index"
    assert result[1].seen == "session s0: the stored version 0 was changed after it was written"
    assert result[-1].seen == "7 sessions are damaged in total"
    assert len(result) == 1 + 5 + 1


def test_a_database_that_cannot_be_read_says_why() -> None:
    (finding,) = findings(error="there is no file /nowhere/voa.db")
    assert (finding.state, finding.seen) == ("wrong", "there is no file /nowhere/voa.db")


def test_doctor_finds_a_changed_version_beside_a_service_that_runs(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    with serving(tmp_path) as service:
        session = service.open(service.create(data_scenario()))
        service.post(f"/v1/sessions/{session}/scans", scan_of([0.5, 0.5, None, 1.0]))
        arguments = ["--json", "--url", "http://127.0.0.1:1", "--database-url", f"sqlite:///{service.database}"]
        seen = []
        for spoil in (None, "UPDATE history SET request = '{}' WHERE version = 1"):
            if spoil is not None:
                connection = sqlite_driver().connect(str(service.database), isolation_level=None)
                connection.execute(spoil)
                connection.close()
            capsys.readouterr()  # the log of the service in this process
            main(arguments)
            result = json.loads(capsys.readouterr().out)["findings"]
            seen.append([each["seen"] for each in result if each["check"] == "database"])
    assert seen[0] == [f"SQLite {sqlite_driver().sqlite_version}: 2 versions of 1 sessions, all checksums match"]
    assert seen[1] == [f"session {session}: the stored version 1 was changed after it was written"]
