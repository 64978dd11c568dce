"""Child processes: input and output, a time limit, and an end that leaves none running."""

import subprocess
import sys
import threading

import pytest

from tests.support.waiting import wait_for
from voa_service.meshes.children import Children

LONG_S = 30.0
ECHO = [sys.executable, "-c", "import sys; sys.stdout.write(sys.stdin.read().upper()); sys.exit(3)"]
HANG = [sys.executable, "-c", "import time; time.sleep(600)"]


def test_a_child_gets_its_input_and_gives_its_output() -> None:
    done = Children().run(ECHO, b"text", LONG_S, {})
    assert (done.stdout, done.stderr, done.returncode) == (b"TEXT", b"", 3)


def test_a_child_has_the_given_environment_alone() -> None:
    program = [sys.executable, "-c", "import os; print(sorted(set(os.environ) & {'SECRET', 'OWN', 'PATH'}))"]
    assert Children().run(program, b"", LONG_S, {"OWN": "1"}).stdout.strip() == b"['OWN']"


def test_a_child_that_takes_too_long_is_killed() -> None:
    with pytest.raises(subprocess.TimeoutExpired):
        Children().run(HANG, b"", 0.2, {})


def test_the_end_kills_the_children_that_run_and_those_to_come() -> None:
    children = Children()
    codes: list[int] = []
    thread = threading.Thread(target=lambda: codes.append(children.run(HANG, b"", LONG_S, {}).returncode))
    thread.start()
    wait_for(lambda: children._running, "the child to start")
    children.close()
    thread.join(LONG_S)
    codes.append(children.run(HANG, b"", LONG_S, {}).returncode)
    assert codes == [-9, -9]


def test_a_program_that_does_not_exist_is_an_error() -> None:
    with pytest.raises(OSError, match="nothing"):
        Children().run(["/nothing"], b"", LONG_S, {})
