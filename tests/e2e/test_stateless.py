"""Stateless to the letter: any process serves any request of a session."""

from itertools import cycle
from pathlib import Path
from typing import Any

import httpx2

from tests.support.replicas import replicas
from voa_msgs import examples

SECONDS = 60.0


def _post(url: str, path: str, body: Any) -> Any:
    answer = httpx2.post(url + path, json=body, timeout=SECONDS)
    assert answer.is_success, answer.text
    return answer.json()


def test_two_processes_serve_one_session_in_turns_as_one_process_would(database_url: str, tmp_path: Path) -> None:
    with replicas(database_url, tmp_path, 2) as both:
        urls = [each.url for each in both]
        scenario = _post(urls[0], "/v1/scenarios", examples.SCENARIO)["id"]
        results = []
        for way in ([urls[0]], urls):
            turn = cycle(way)
            session = _post(next(turn), "/v1/sessions", {"scenario": scenario})["id"]
            path = f"/v1/sessions/{session}"
            answers = []
            for version in range(1, 7):
                if version % 3 == 0:
                    answers.append(_post(next(turn), f"{path}/grasp-outcomes", examples.OUTCOME))
                else:
                    answers.append(_post(next(turn), f"{path}/scans", examples.SCAN))
                seen = httpx2.get(next(turn) + path, timeout=SECONDS).json()
                assert seen["version"] == version
                assert seen["belief"] == answers[-1]["belief"]
                ranking = _post(next(turn), f"{path}/voa", {})
                assert ranking["version"] == version
                answers.append(ranking["ranking"])
            results.append([answer["belief"] if isinstance(answer, dict) else answer for answer in answers])
    assert results[0] == results[1]
