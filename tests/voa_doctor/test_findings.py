"""Time limits of checks, and what counts as a difference of clocks."""

import threading

import pytest

from voa_doctor.findings import Budget, TookTooLong
from voa_doctor.over_http import clocks


def test_a_clock_is_only_blamed_beyond_the_uncertainty() -> None:
    assert clocks("clock", 0.3, 0.25).state == "ok"
    assert clocks("clock", -0.3, 0.1).state == "warning"


def test_work_that_hangs_is_left_behind() -> None:
    with pytest.raises(TookTooLong):
        Budget(60.0).within(0.05, threading.Event().wait)
    assert Budget(60.0).within(5.0, lambda: 3) == 3
    with pytest.raises(ZeroDivisionError):
        Budget(60.0).within(5.0, lambda: 1 // 0)
    assert Budget(0.0).step(5.0) <= 0.05
