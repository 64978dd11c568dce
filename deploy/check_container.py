"""Check running containers for `make image`: the main job, its session again after a restart, and the console's pages.

`check_container.py work URL FILE` stores the mug's scenario, opens a session, ranks, applies a scan, ranks again, and
writes the session into FILE; `check_container.py recall URL FILE` requests that session and compares it with FILE;
`check_container.py page URL FILE` opens the console's page on that session.
"""

import http.client
import sys
import time
from collections.abc import Sequence
from http import HTTPStatus
from pathlib import Path

from voa_assets import path as asset_path
from voa_client import Client, PredictionsRequest, Scan, ScanRequest, Session, SessionRequest, UnreachableError
from voa_client.scenario_files import load_scenario

TRUE_POSE = "U_90"
_START_SECONDS = 60.0
_PAUSE_SECONDS = 0.05


def main(arguments: Sequence[str]) -> int:
    """Run `work`, `recall` or `page` with its URL and file; return the exit code, 1 if the container is wrong."""
    command, url, file = arguments
    if command == "page":
        return _page(url, Session.model_validate_json(Path(file).read_text(encoding="utf-8")))
    with Client(url) as client:
        print(f"  /readyz: {_wait(client)}")
        if command == "work":
            Path(file).write_text(_work(client).model_dump_json(), encoding="utf-8")
            return 0
        expected = Session.model_validate_json(Path(file).read_text(encoding="utf-8"))
        session = client.get_session(expected.id)
        print(f"  session {session.id} is at version {session.version}, best grasp {session.best_grasp}")
        if session != expected:
            print(f"  but it was at version {expected.version}, best grasp {expected.best_grasp}", file=sys.stderr)
        return int(session != expected)


def _wait(client: Client) -> str:
    """Wait until the service is ready, at most a minute; return its status."""
    until = time.monotonic() + _START_SECONDS
    while True:
        try:
            return client.ready().status
        except UnreachableError:
            if time.monotonic() > until:
                raise
            time.sleep(_PAUSE_SECONDS)


def _work(client: Client) -> Session:
    """Store a scenario, open a session, rank the looks and apply a scan; return the session."""
    scenario = load_scenario(client, asset_path("mug") / "scenario.json")
    session = client.create_session(SessionRequest(scenario=scenario.id))
    started = time.perf_counter()
    look = client.rank_looks(session.id).ranking[0].sensor
    print(f"  first ranking in {time.perf_counter() - started:.2f} s: look from {look}")
    predicted = client.predict(scenario.id, PredictionsRequest(sensors=[look]))
    ranges = predicted.ranges[0][predicted.poses.index(TRUE_POSE)]
    nothing = [beam for beam, value in enumerate(ranges) if value is None]
    request = ScanRequest(sensor=look, scan=Scan(ranges=ranges, no_return=nothing))
    started = time.perf_counter()
    updated = client.apply_scan(session.id, request)
    print(f"  scan applied in {1e3 * (time.perf_counter() - started):.0f} ms: best grasp {updated.best_grasp}")
    again = client.rank_looks(session.id).recommendation
    print(f"  recommended then: {again.action}")
    return client.get_session(session.id)


def _page(url: str, session: Session) -> int:
    """Open the console's page on a session; return 1 if it is not served, or does not name the session."""
    connection = http.client.HTTPConnection(url.removeprefix("http://"), timeout=_START_SECONDS)
    connection.request("GET", f"/sessions/{session.id}")
    answer = connection.getresponse()
    text = answer.read().decode()
    print(f"  the console's page on the session: {answer.status}, {len(text)} characters")
    return int(answer.status != HTTPStatus.OK or session.id not in text)


if __name__ == "__main__":
    raise SystemExit(main(sys.argv[1:]))
