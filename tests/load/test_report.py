"""Verdicts from the figures of a load: carried, late or refused, and what the limit is."""

from collections import Counter
from dataclasses import replace

import pytest
from rich.console import Console

from tests.load.report import summary, verdict
from tests.load.steps import Step, step_of

CARRIED = Step(10, 8.0, 400, 3.0, 20.0, 40.0, {}, 0, {"service": 0.8, "robots": 0.1, "machine": 1.0}, {})
SLOW = replace(CARRIED, sessions=20, scans=800, p99_ms=201.0)


def busy(service: float, machine: float) -> Step:
    """A step that is late, with so many cores in use."""
    return replace(SLOW, cpu_s={"service": 8.0 * service, "robots": 0.8, "machine": 8.0 * machine})


def test_figures_are_per_second_and_per_scan() -> None:
    assert CARRIED.scans_per_s == 50.0
    assert CARRIED.cpu_ms_per_scan == pytest.approx(2.0)
    assert CARRIED.cores["machine"] == pytest.approx(0.125)


@pytest.mark.parametrize(
    ("step", "reason"),
    [
        (CARRIED, None),
        (SLOW, "late"),
        (replace(CARRIED, scans=379), "behind"),
        (replace(CARRIED, scans=381), None),
        (replace(CARRIED, refused={"429": 1}), "refuses"),
    ],
)
def test_a_service_carries_sessions_if_it_answers_each_scan_before_the_next(step: Step, reason: str | None) -> None:
    assert step.reason == reason


def test_times_are_summarised_and_none_are_invented() -> None:
    step = step_of(1, 2.0, [float(ms) for ms in range(100, 0, -1)], Counter(), 0, {}, {})
    assert (step.p50_ms, step.p99_ms, step.most_ms) == (51.0, 100.0, 100.0)
    assert step_of(1, 2.0, [], Counter(), 0, {}, {}).scans == 0


@pytest.mark.parametrize(
    ("steps", "processes", "says"),
    [
        ([CARRIED], 1, "carries 10 sessions, and more were not tried"),
        ([CARRIED, busy(0.95, 1.5)], 1, "at 20 p99 exceeds 200 ms: 1 core(s) of Python for 1 process(es) are used up"),
        ([CARRIED, busy(0.95, 1.5)], 2, "it waits, and not for a processor"),
        ([CARRIED, busy(0.5, 1.99)], 1, "used up (service 0.50, robots 0.10, other programs 1.39)"),
        ([SLOW], 1, "carries 0 sessions"),
        (
            [CARRIED, replace(SLOW, refused={"429": 7}, causes={"too-many-requests": "200 per second"})],
            1,
            "at 20 it refuses (7 x 429, each with Retry-After): too-many-requests: 200 per second",
        ),
        ([replace(SLOW, refused={"500": 7}, impolite=7)], 1, "7 without Retry-After): no reason is given"),
    ],
)
def test_the_verdict_names_the_limit(steps: list[Step], processes: int, says: str) -> None:
    assert says in verdict(steps, processes, cores=2)


def test_the_summary_has_the_most_sessions_that_each_service_carries() -> None:
    console = Console(width=120)
    with console.capture() as printed:
        console.print(summary({"quick": [replace(CARRIED, sessions=9), CARRIED, SLOW], "slow": [SLOW, SLOW]}))
    rows = [[cell.strip() for cell in line.split("|")] for line in printed.get().splitlines() if "|" in line]
    assert [row[1:3] for row in rows[2:]] == [["quick", "10"], ["slow", "(20: late)"]]
