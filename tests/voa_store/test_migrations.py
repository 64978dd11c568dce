"""A database of an earlier version keeps what is in it."""

import json
from datetime import UTC, datetime
from pathlib import Path

import numpy as np
import pytest
from sqlalchemy import Engine, text

from tests.support.releases import at_revision
from tests.voa_core.worlds import box
from tests.voa_store.samples import change, looking, next_version, write
from voa_core.objects import Object
from voa_store.records import RobotLook, StoredKey, StoredResponse, Upload, Write
from voa_store.sql import SqlStore
from voa_store.verify import main

INSERT_OBJECT = text(
    "INSERT INTO objects (id, name, created_at, vertices, faces) VALUES (:id, 'box', :at, :vertices, :faces)"
)
AT = datetime(2026, 11, 28, tzinfo=UTC).isoformat()


def row_of(mesh: Object) -> dict[str, object]:
    """The parameters of `INSERT_OBJECT`."""
    return {"id": mesh.digest, "at": AT, "vertices": mesh.vertices.tobytes(), "faces": mesh.faces.tobytes()}


def test_objects_from_before_up_was_kept_were_read_with_z_up(tmp_path: Path) -> None:
    url, mesh = f"sqlite:///{tmp_path}/old.db", box(0.1, 0.2, 0.3)
    engine = at_revision(url, "0001")
    with engine.begin() as connection:
        connection.execute(INSERT_OBJECT, row_of(mesh))
    engine.dispose()
    store = SqlStore(url)
    stored = store.get_object(mesh.digest)
    assert stored is not None
    assert (stored.up, stored.object.digest) == ("+Z", mesh.digest)
    store.close()


def insert_session(engine: Engine, *ids: str) -> None:
    """Put sessions on a scenario "A" of their own, at version 0."""
    blob = np.array([[0.5, 0.5], [-0.7, -0.7]]).tobytes()
    scenario = text("INSERT INTO scenarios (id, name, created_at, body) VALUES ('A', 'A', :at, '{}')")
    session = text(
        "INSERT INTO sessions (id, scenario, version, belief, prior, created_at, updated_at) "
        "VALUES (:id, 'A', 0, :blob, :blob, :at, :at)"
    )
    with engine.begin() as connection:
        connection.execute(scenario, {"at": AT})
        for id_ in ids:
            connection.execute(session, {"id": id_, "blob": blob, "at": AT})


def test_sessions_from_before_robots_kept_one_are_listed_and_claimed(database_url: str) -> None:
    engine = at_revision(database_url, "0002")
    insert_session(engine, "older", "newest")
    engine.dispose()
    store = SqlStore(database_url)
    assert store.robot_session("tb3_1", "A") == store.settle_robot("tb3_1", "A") == "newest"
    assert store.claim_robot("tb3_1", "older")
    assert store.robot_session("tb3_1", "A") == "older"
    store.close()


def test_a_mesh_from_before_uploads_were_kept_is_uploaded_once_more(tmp_path: Path) -> None:
    url, mesh = f"sqlite:///{tmp_path}/old.db", box(0.1, 0.2, 0.3)
    engine = at_revision(url, "0002")
    with engine.begin() as connection:
        connection.execute(INSERT_OBJECT, row_of(mesh))
    engine.dispose()
    store, upload = SqlStore(url), Upload("0" * 64, "obj", 1.0, "+Z")
    assert store.find_upload(upload) is None
    store.put_upload(upload, mesh.digest)
    stored = store.find_upload(upload)
    assert stored is not None
    assert stored.object.digest == mesh.digest
    store.close()


def test_a_session_from_before_looks_were_counted_counts_its_next_one(database_url: str) -> None:
    engine = at_revision(database_url, "0004")
    insert_session(engine, "S")
    engine.dispose()
    store, counted = SqlStore(database_url), RobotLook("tb3_1", 1, "digest")
    assert store.robot_looks("S", "tb3_1", 9) == []
    change(store, "S", Write("scan", "{}", None, None, counted), next_version)
    assert store.robot_looks("S", "tb3_1", 9) == [counted]
    store.close()


def test_sessions_and_lists_from_before_checksums_are_filled_in(database_url: str) -> None:
    engine, mesh = at_revision(database_url, "0005"), box(0.1, 0.2, 0.3)
    blob = np.array([[0.5, 0.5], [-0.7, -0.7]]).tobytes()
    body = '{"grasps": [{}], "object": null, "poses": [{}, {}], "sensors": [{}], "update": {"rule": "beam"}}'
    with engine.begin() as connection:
        connection.execute(INSERT_OBJECT, row_of(mesh))
        connection.execute(
            text("INSERT INTO scenarios (id, name, created_at, body) VALUES ('A', 'A', :at, :body)"),
            {"at": AT, "body": body},
        )
        connection.execute(
            text(
                "INSERT INTO sessions (id, scenario, version, belief, prior, last_fit_rmsd_mm, created_at, updated_at)"
                " VALUES ('S', 'A', 250, :blob, :blob, 0.1, :at, :at)"
            ),
            {"blob": blob, "at": AT},
        )
        connection.execute(
            text(
                "INSERT INTO history (session, version, kind, at, request, report, belief, last_fit_rmsd_mm)"
                " VALUES ('S', :version, 'scan', :at, '{\"ü\": 1}', NULL, :blob, 0.1)"
            ),
            [{"version": version, "blob": blob, "at": AT} for version in range(251)],
        )
    engine.dispose()
    store = SqlStore(database_url)
    assert [entry.state.version for entry in store.history("S", -1, 999)] == list(range(251))
    assert change(store, "S", write(), next_version) == StoredResponse("v251", 251)
    assert len(store.history("S", 249, 9)) == 2
    (scenario,) = store.list_scenarios(9, None).items
    assert json.loads(scenario.summary) == {"object": None, "poses": 2, "grasps": 1, "sensors": 1, "rule": "beam"}
    (listed,) = store.list_objects(9, None).items
    assert (listed.extents, listed.faces) == (tuple(mesh.extents.tolist()), len(mesh.faces))
    (session,) = store.list_sessions(9, None).items
    assert session.summary is None
    store.close()


CHECKSUMS = ["5dd9d12eaf01a3cc0256eade9af6a78a", "d0fe9d0ff500c9f6287b4c8ca9754bd0", "662017e8adcadf5e014e6b5739b86b05"]
CHECKSUM_OF_SESSION = "dd02eb0f868c6f9a8c37ab89d3ff21ae"
"""Checksums of the rows below, as the service computed them before it recorded looks."""


def insert_history(engine: Engine) -> None:
    """Put a session of three versions, with the checksums of a service that records no looks."""
    blob = np.array([[0.5, 0.5], [-0.7, -0.7]]).astype("<f8").tobytes()
    with engine.begin() as connection:
        connection.execute(
            text("INSERT INTO scenarios (id, name, created_at, body) VALUES ('A', 'A', :at, '{}')"), {"at": AT}
        )
        connection.execute(
            text(
                "INSERT INTO sessions (id, scenario, version, belief, prior, last_fit_rmsd_mm, created_at, updated_at, "
                "summary, newest, checksum) "
                "VALUES ('S', 'A', 2, :blob, :blob, 0.1, :at, :at, :summary, :newest, :checksum)"
            ),
            {
                "blob": blob,
                "at": AT,
                "summary": '{"entropy_nats": 0.1}',
                "newest": bytes.fromhex(CHECKSUMS[-1]),
                "checksum": bytes.fromhex(CHECKSUM_OF_SESSION),
            },
        )
        connection.execute(
            text(
                "INSERT INTO history (session, version, kind, at, request, report, belief, last_fit_rmsd_mm, checksum) "
                "VALUES ('S', :version, :kind, :at, :request, :report, :blob, :fit, :checksum)"
            ),
            [
                {
                    "version": version,
                    "kind": "scan" if version else "prior",
                    "at": AT,
                    "request": '{"ü": 1}',
                    "report": '{"accepted": true}' if version else None,
                    "blob": blob,
                    "fit": 0.1 if version else None,
                    "checksum": bytes.fromhex(checksum),
                }
                for version, checksum in enumerate(CHECKSUMS)
            ],
        )


def test_sessions_from_before_looks_were_recorded_keep_their_checksums_and_go_on(
    database_url: str, capsys: pytest.CaptureFixture[str]
) -> None:
    engine = at_revision(database_url, "0006")
    insert_history(engine)
    engine.dispose()
    assert main([database_url]) == 2, "its tables are those of the earlier version"
    capsys.readouterr()
    store = SqlStore(database_url)
    assert main([database_url]) == 0
    report = json.loads(capsys.readouterr().out)
    assert (report["sessions"], report["versions"], report["damaged"]) == (1, 3, [])
    before = store.get_session("S")
    assert before is not None
    assert (before.version, before.looks, before.under_way) == (2, None, None)
    assert [entry.state.looks for entry in store.history("S", -1, 9)] == [None] * 3
    change(store, "S", write(), looking('{"since":2}'))
    assert [entry.state.looks for entry in store.history("S", -1, 9)] == [None, None, None, '{"since":2}']
    assert main([database_url]) == 0
    store.close()


def test_a_service_from_before_keys_stays_open_until_the_first_one(database_url: str) -> None:
    engine = at_revision(database_url, "0007")
    insert_history(engine)
    engine.dispose()
    store = SqlStore(database_url)
    assert store.list_keys() == []
    store.put_key(StoredKey("id", b"digest", "anna", "operator", datetime(2026, 11, 28, tzinfo=UTC)))
    assert [key.name for key in store.list_keys()] == ["anna"]
    assert change(store, "S", write(), next_version) == StoredResponse("v3", 3)
    store.close()
