"""CPU time of a process counts its children, those that have ended included."""

import os
import subprocess
import sys

from tests.load.usage import cpu_seconds, machine_seconds

BUSY = "import time\nwhile time.process_time() < 0.3: pass\n"


def test_a_child_counts_while_it_runs_and_after_it_has_ended() -> None:
    before, machine = cpu_seconds([os.getpid()]), machine_seconds()
    child = subprocess.Popen([sys.executable, "-c", BUSY + "input()"], stdin=subprocess.PIPE)
    try:
        while cpu_seconds([child.pid]) < 0.25:
            pass
        assert cpu_seconds([os.getpid()]) - before >= 0.25
    finally:
        child.communicate(b"\n", timeout=30)
    assert child.returncode == 0
    assert cpu_seconds([os.getpid()]) - before >= 0.25
    assert machine_seconds() - machine >= 0.25
