"""Attacks by a clock: it is set forward and back, by seconds and by years, under writers."""

from pathlib import Path

from tests.chaos.attack import Attack, Outcome
from tests.support.history_calls import Recorder, opened
from tests.support.history_chaos import random_numbers
from tests.support.history_store import check_stored
from tests.support.machine_clock import MachineClock
from tests.support.postgres import server
from tests.support.replicas import Replica, replicas

_DAY = 86_400.0
_JUMPS_S = (-400 * _DAY, -_DAY, -3_600.0, -30.0, 0.0, 30.0, 3_600.0, _DAY, 8 * _DAY, 400 * _DAY)
_JUMPS, _ANSWERS = 30, 40


def replicas_whose_clocks_jump(folder: Path) -> Outcome:
    """Set the clocks of two replicas apart, forward and back, while writers write and retention removes."""
    recorder, rng = Recorder(), random_numbers(0)
    with server() as own:
        url = own.new_database()
        # The mesh reader's own process does not start under libfaketime.
        with replicas(url, folder) as (plain,):
            sessions = opened(recorder, plain.url, 10)
        clocks = [MachineClock(folder / f"clock-{n}") for n in range(2)]
        settings = {"VOA_RETENTION_DAYS": "30", "VOA_RESPONSE_DAYS": "7"}
        both = [
            Replica(url, folder / f"jumping-{n}.log", environment=clock.environment | settings)
            for n, clock in enumerate(clocks)
        ]
        try:
            for replica in both:
                replica.start()
            with recorder.running([replica.url for replica in both], sessions, 8):
                for number in range(_JUMPS):
                    recorder.wait_for(_ANSWERS)
                    rng.choice(clocks).set(rng.choice(_JUMPS_S))
                    if number % 10 == 9:  # a process that starts with a wrong clock
                        victim = rng.choice(both)
                        victim.kill()
                        victim.start()
        finally:
            for replica in both:
                replica.end()
        versions = check_stored(url, recorder.calls)
    figure = f"{recorder.answered} writes answered, {_JUMPS} jumps: 0 lost, 0 twice"
    return Outcome(figure, f"{versions} versions replayed", versions > 0)


ATTACKS = [
    Attack(
        "clocks: two replicas whose clocks jump by up to 400 days",
        "not tried",
        "0 lost, 0 twice",
        replicas_whose_clocks_jump,
    ),
]
