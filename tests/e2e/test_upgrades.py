"""Databases that earlier releases have written are upgraded when the service starts, and nothing in them is lost."""

import json
import subprocess
from collections.abc import Iterator
from contextlib import closing
from pathlib import Path
from typing import NamedTuple

import numpy as np
import pytest
from sqlalchemy import text

from tests.support.postgres import Server, binaries
from tests.support.releases import VERSIONS, Call, calls, load
from tests.support.replaying import replayed
from tests.support.serving import Json, Service, scan_of, serving
from tests.voa_store.samples import engine_of
from voa_core.filtering import Belief
from voa_service.serve import main as serve
from voa_store.backups import back_up, restore
from voa_store.drivers import sqlite_driver
from voa_store.sql import SqlStore
from voa_store.verify import main as verify

ULPS = 64
"""Units in the last place by which a replay may differ: 8 on another type of machine, and more where a mesh predicts
the scans, whose ranges are computed by another formula since (changelog)."""


class Upgraded(NamedTuple):
    """Service that has upgraded the database of a release, and what the release responded."""

    service: Service
    url: str
    calls: list[Call]

    @property
    def newest(self) -> dict[str, Json]:
        """Newest state of each session as the release reported it, by the session's id."""
        bodies = [json.loads(call.response) for call in self.calls if call.response]
        gone = {call.path.rsplit("/", 1)[1] for call in self.calls if call.method == "DELETE"}
        return {body["id"]: body for body in bodies if body["id"] not in gone}


@pytest.fixture(scope="module", params=VERSIONS)
def release(request: pytest.FixtureRequest) -> str:
    """The version of an earlier release."""
    return str(request.param)


@pytest.fixture(scope="module", params=["sqlite", "postgresql"])
def upgraded(
    request: pytest.FixtureRequest, release: str, postgres: Server, tmp_path_factory: pytest.TempPathFactory
) -> Iterator[Upgraded]:
    """A service on the database of a release, which no test changes."""
    folder = tmp_path_factory.mktemp("upgraded")
    url = postgres.new_database() if request.param == "postgresql" else f"sqlite:///{folder / 'voa.db'}"
    load(release, url)
    with serving(folder, database_url=url) as service:
        yield Upgraded(service, url, calls(release))


def verified(url: str, capsys: pytest.CaptureFixture[str]) -> tuple[int, int]:
    """Verify a database in which nothing may be damaged; return the numbers of sessions and versions."""
    capsys.readouterr()
    assert verify([url]) == 0
    report = json.loads(capsys.readouterr().out)
    return report["sessions"], report["versions"]


def test_every_session_is_as_the_release_reported_it_and_verified(
    upgraded: Upgraded, capsys: pytest.CaptureFixture[str]
) -> None:
    newest = upgraded.newest
    assert verified(upgraded.url, capsys) == (4, sum(body["version"] + 1 for body in newest.values()))
    listed = upgraded.service.get("/v1/sessions")["items"]
    assert {item["id"]: item["version"] for item in listed} == {id_: body["version"] for id_, body in newest.items()}
    for id_, before in newest.items():
        now = upgraded.service.get(f"/v1/sessions/{id_}")
        same = ("scenario", "version", "poses", "belief", "best_grasp", "expected_score", "last_fit_rmsd_mm")
        assert {name: now[name] for name in same} == {name: before[name] for name in same}


def test_a_repeated_call_gets_the_response_of_the_release_byte_for_byte(upgraded: Upgraded) -> None:
    http = upgraded.service.http
    repeated = [call for call in upgraded.calls if call.key is not None]
    assert len(repeated) > 15
    for call in repeated:
        headers = {"Content-Type": "application/json", "Idempotency-Key": str(call.key)}
        answer = http.request(call.method, call.path, content=call.body, headers=headers)
        assert (answer.status_code, answer.text) == (call.status, call.response), call
    versions = {item["id"]: item["version"] for item in upgraded.service.get("/v1/sessions")["items"]}
    assert versions == {id_: body["version"] for id_, body in upgraded.newest.items()}, "nothing was done twice"


def test_histories_replay_to_their_beliefs_but_for_looks_from_uncertain_poses(upgraded: Upgraded) -> None:
    """Sensor poses with a stated `std`, and outcomes of measured scores, are weighed differently since (changelog)."""
    sessions = upgraded.service.inside.sessions
    different = set()
    for id_ in upgraded.newest:
        state = sessions.store.get_session(id_)
        assert state is not None
        entries = sessions.store.history(id_, -1, 99)
        scenario = sessions.model_of(state).scenario
        for entry, estimate in zip(entries, replayed(scenario, entries), strict=True):
            if not _equal(estimate.belief, entry.state.belief):
                different.add((entry.kind, entry.state.version, "std" in "".join(e.request for e in entries)))
    assert different == {("scan", 3, True), ("outcome", 4, True)}


def _equal(one: Belief, other: Belief) -> bool:
    pairs = ((one.p, other.p), (one.log_p, other.log_p))
    return all(np.allclose(a, b, rtol=ULPS * np.finfo(float).eps, atol=0.0) for a, b in pairs)


def go_on(service: Service) -> str:
    """Send a scan to the first session of a release, which must be accepted; return the session's id."""
    listed = service.get("/v1/sessions")["items"][0]
    answer = service.post(f"/v1/sessions/{listed['id']}/scans", scan_of([0.6, 0.5, None, 1.0]))
    assert (answer["version"], answer["update"]["accepted"]) == (listed["version"] + 1, True)
    (added,) = service.get(f"/v1/sessions/{listed['id']}/history?after={listed['version']}")["items"]
    assert added["version"] == answer["version"]
    return str(listed["id"])


def rows(file: Path) -> list[str]:
    """Read a database of SQLite: how its tables are made, and all rows."""
    with closing(sqlite_driver().connect(str(file))) as connection:
        tables = connection.execute("SELECT name, sql FROM sqlite_master WHERE type = 'table' ORDER BY name").fetchall()
        contents = [connection.execute(f'SELECT * FROM "{name}" ORDER BY 1').fetchall() for name, _ in tables]  # noqa: S608 - names from this code alone
    return [repr(each) for each in (*tables, *contents)]


def test_a_backup_before_the_upgrade_is_what_the_release_can_go_back_to(
    release: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    database, backup = tmp_path / "voa.db", tmp_path / "before.db"
    load(release, f"sqlite:///{database}")
    written = rows(database)
    made = back_up(f"sqlite:///{database}", backup)
    assert (made.verified.well, made.verified.sessions) == (True, 4)
    with serving(tmp_path) as service:
        id_ = go_on(service)
    assert verified(f"sqlite:///{database}", capsys)[0] == 4
    assert rows(database) != written
    assert rows(backup) == written, "tables and rows as the release wrote them, for its own service"
    restored = restore(backup, f"sqlite:///{database}")
    assert (restored.verified.well, restored.verified.sessions) == (True, 4)
    with serving(tmp_path) as service:
        newest = service.get(f"/v1/sessions/{id_}")
    assert newest["version"] == Upgraded(service, "", calls(release)).newest[id_]["version"]


def test_an_older_service_refuses_newer_tables_in_one_line(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    SqlStore(f"sqlite:///{tmp_path}/voa.db").close()
    with closing(sqlite_driver().connect(str(tmp_path / "voa.db"))) as connection:
        connection.execute("UPDATE alembic_version SET version_num = '9999'")
        connection.commit()
    assert serve(["--port", "0", "--database-url", f"sqlite:///{tmp_path}/voa.db"]) == 1
    (line,) = [line for line in capsys.readouterr().err.splitlines() if line.startswith("voa serve: ")]
    assert "was written by a newer version of voa" in line
    assert "start that version, or restore the backup that was made before it" in line


def test_a_dump_before_the_upgrade_is_restored_into_a_database_of_its_own(postgres: Server, tmp_path: Path) -> None:
    url, other, file = postgres.new_database(), postgres.new_database(), tmp_path / "before.dump"
    load("0.2.0", url)
    subprocess.run([binaries() / "pg_dump", "--format=custom", f"--file={file}", url], check=True)
    with serving(tmp_path, database_url=url) as service:
        id_ = go_on(service)
    subprocess.run([binaries() / "pg_restore", "--no-owner", f"--dbname={other}", file], check=True)
    engine = engine_of(other)
    with engine.connect() as connection:
        assert connection.execute(text("SELECT version_num FROM alembic_version")).scalar_one() == "0006"
    engine.dispose()
    with serving(tmp_path, database_url=other) as service:
        newest = service.get(f"/v1/sessions/{id_}")
    assert newest["version"] == Upgraded(service, "", calls("0.2.0")).newest[id_]["version"]
