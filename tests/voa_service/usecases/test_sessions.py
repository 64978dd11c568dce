"""Pages of histories and of sessions, as callers see them."""

from pathlib import Path

from tests.support.serving import data_scenario, scan_of, serving
from voa_store.drivers import sqlite_driver

SCANS = 6


def test_a_history_goes_on_where_a_page_is_full_of_bytes(tmp_path: Path) -> None:
    with serving(tmp_path, limits={"history_bytes": 1_000}) as service:
        session = service.open(service.create(data_scenario()))
        for number in range(SCANS):
            service.post(f"/v1/sessions/{session}/scans", scan_of([0.5, 0.5, None, 1.0], stamp=number))
        versions, sizes, after = list[int](), list[int](), ""
        while True:
            page = service.get(f"/v1/sessions/{session}/history{after}")
            versions += [item["version"] for item in page["items"]]
            sizes.append(len(page["items"]))
            if page["next"] is None:
                break
            after = f"?after={page['next']}"
        assert versions == list(range(SCANS + 1))
        assert len(sizes) > 1
        assert min(sizes) >= 1


def test_a_list_of_sessions_says_what_each_one_says(tmp_path: Path) -> None:
    with serving(tmp_path) as service:
        scenario = service.create(data_scenario())
        sessions = [service.open(scenario) for _ in range(3)]
        service.post(f"/v1/sessions/{sessions[0]}/scans", scan_of([0.5, 0.5, None, 1.0]))
        service.http.put(f"/v1/sessions/{sessions[1]}/belief", json={"belief": [0.2, 0.3, 0.5]}).raise_for_status()
        service.post(f"/v1/sessions/{sessions[2]}/grasp-outcomes", {"grasp": "G1", "success": False})
        with sqlite_driver().connect(str(service.database), isolation_level=None) as connection:
            assert connection.execute("SELECT count(*) FROM sessions WHERE summary IS NULL").fetchone() == (0,)
        connection.close()
        for listed in service.get("/v1/sessions")["items"]:
            whole = service.get(f"/v1/sessions/{listed['id']}")
            assert listed == {name: whole[name] for name in listed}


def test_a_damaged_session_is_a_problem_with_its_version(tmp_path: Path) -> None:
    with serving(tmp_path) as service:
        scenario = service.create(data_scenario())
        damaged, other = service.open(scenario), service.open(scenario)
        connection = sqlite_driver().connect(str(service.database), isolation_level=None)
        connection.execute("UPDATE sessions SET prior = zeroblob(48) WHERE id = ?", (damaged,))
        connection.close()
        answer = service.http.get(f"/v1/sessions/{damaged}")
        assert (answer.status_code, answer.json()["type"]) == (500, "urn:voa:problem:damaged")
        assert answer.json()["version"] == 0
        assert damaged in answer.json()["detail"]
        assert service.get(f"/v1/sessions/{other}")["version"] == 0
        assert service.http.delete(f"/v1/sessions/{damaged}").status_code == 204
