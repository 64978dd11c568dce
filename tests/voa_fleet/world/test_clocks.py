"""Virtual time takes none; real time passes as it should."""

import time

from voa_fleet.world.clocks import RealClock, VirtualClock


def test_virtual_time_passes_when_slept() -> None:
    clock, started = VirtualClock(), time.monotonic()
    clock.sleep(3600.0)
    clock.sleep(0.5)
    assert clock.now_s() == 3600.5
    assert time.monotonic() - started < 1.0


def test_real_time_passes_and_work_between_two_sleeps_is_taken_off() -> None:
    clock = RealClock()
    started = clock.now_s()
    for _ in range(5):
        clock.sleep(0.02)
        busy_until = time.monotonic() + 0.01
        while time.monotonic() < busy_until:
            pass
    clock.sleep(0.02)
    assert clock.now_s() - started >= 0.12 - 1e-3
