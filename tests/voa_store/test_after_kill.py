"""Every answered write is there when the service starts again, whatever ended it."""

import os
import signal
from pathlib import Path

import httpx2

from tests.support.serving import data_scenario, scan_of, serving
from voa_client.local import running


def test_a_killed_service_has_kept_every_answered_write(tmp_path: Path) -> None:
    options = ["--database-url", f"sqlite:///{tmp_path / 'voa.db'}"]
    with running("voa_service", options, tmp_path / "first.log") as process:
        with httpx2.Client(base_url=process.url, timeout=60.0) as http:
            scenario = http.post("/v1/scenarios", json=data_scenario()).json()
            session = http.post("/v1/sessions", json={"scenario": scenario["id"]}).json()
            gone = http.post("/v1/sessions", json={"scenario": scenario["id"]}).json()
            assert http.delete(f"/v1/sessions/{gone['id']}").status_code == 204
            path = f"/v1/sessions/{session['id']}"
            bodies = [scan_of([0.5 + 0.01 * i, 0.5, None, 1.0], stamp=i) for i in range(20)]
            answers = [
                http.post(f"{path}/scans", json=body, headers={"idempotency-key": f"scan {i}"})
                for i, body in enumerate(bodies)
            ]
            assert [answer.json()["version"] for answer in answers] == list(range(1, 21))
        os.kill(process.pid, signal.SIGKILL)
    with serving(tmp_path) as service:
        last = {key: value for key, value in answers[-1].json().items() if key != "update"}
        # The scan fits poorly, of which its own answer alone warns.
        assert last["warnings"][:-1] == scenario["warnings"]
        assert service.get(path) == last | {"warnings": scenario["warnings"]}
        assert service.http.get(f"/v1/sessions/{gone['id']}").status_code == 404
        assert service.get(f"/v1/scenarios/{scenario['id']}") == scenario
        entries = service.get(f"{path}/history")["items"]
        assert [entry["version"] for entry in entries] == list(range(21))
        assert [entry["request"] for entry in entries[1:]] == bodies
        assert [entry["update"] for entry in entries[1:]] == [answer.json()["update"] for answer in answers]
        # The answers are kept too: a client that saw none sends again, and nothing happens twice.
        again = service.http.post(f"{path}/scans", json=bodies[-1], headers={"idempotency-key": "scan 19"})
        assert again.content == answers[-1].content
        # And the history replays to the same belief, bit for bit.
        replayed = service.open(scenario["id"])
        for body in bodies:
            session = service.post(f"/v1/sessions/{replayed}/scans", body)
        assert session["belief"] == last["belief"]
