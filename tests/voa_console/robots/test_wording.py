"""Findings about the service in plain words."""

import pytest

from voa_console.robots.wording import plain, tally
from voa_doctor.findings import Finding, State
from voa_doctor.memory import check_memory
from voa_msgs.problems import Memory


@pytest.mark.parametrize(
    ("finding", "text"),
    [
        (Finding("HTTP", "ok", "lab:8000 accepts connections"), "connection: lab:8000 accepts connections"),
        (Finding("ready", "ok", "ready"), "readiness: the service and its database accept requests"),
        (Finding("service", "ok", "runs"), "service: the service runs"),
        (Finding("clock", "ok", "0.002 s behind ours"), "clock: 0.002 s behind ours"),
    ],
)
def test_a_finding_in_plain_words(finding: Finding, text: str) -> None:
    assert f"{plain(finding).check}: {plain(finding).seen}" == text


def test_the_parts_of_the_memory_say_what_they_hold() -> None:
    memory = Memory(
        total_mebibytes=100,
        source="machine",
        sum_mebibytes=60,
        process_mebibytes=20,
        cache_mebibytes=10,
        workers_mebibytes=10,
        meshes_mebibytes=10,
        bodies_mebibytes=10,
    )
    (finding,) = check_memory(memory)
    seen = plain(finding).seen
    assert "processes that compute 10, meshes 10, requests under way 10" in seen
    assert "stored results 10" in seen
    assert "bodies" not in seen


@pytest.mark.parametrize(
    ("state", "number", "text"),
    [
        ("ok", 7, "7 checks passed"),
        ("ok", 1, "1 check passed"),
        ("warning", 1, "1 check with a warning"),
        ("wrong", 2, "2 checks did not pass"),
    ],
)
def test_a_tally(state: State, number: int, text: str) -> None:
    assert tally(state, number) == text
