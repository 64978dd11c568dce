"""Tests that `make test` runs at the lowest priority wait for nothing that is late where the cores are taken."""

import ast
import re
from pathlib import Path

import pytest

REPOSITORY = Path(__file__).resolve().parents[2]
FIXTURES = {"browser", "console", "database_url", "page", "postgres", "process"}
"""Fixtures that start a program, and wait for it."""
WAITING = {"local_service", "monotonic", "perf_counter", "replicas", "router", "running", "wait_for"}
"""Functions that start a service, wait for a condition, or read the time of day that has passed."""


def computing() -> list[str]:
    """List the folders of the Makefile's COMPUTING, relative to tests/."""
    text = (REPOSITORY / "Makefile").read_text(encoding="utf-8").replace("\\\n", " ")
    folders = re.search(r"(?m)^COMPUTING := \$\(addprefix tests/,(.*)\)$", text)
    assert folders is not None
    return folders[1].split()


def waiting(program: str) -> set[str]:
    """Return what a file of tests uses that waits."""
    nodes = list(ast.walk(ast.parse(program)))
    arguments = {node.arg for node in nodes if isinstance(node, ast.arg)}
    called = {node.func for node in nodes if isinstance(node, ast.Call)}
    names = {each.id for each in called if isinstance(each, ast.Name)}
    names |= {each.attr for each in called if isinstance(each, ast.Attribute)}
    return (arguments & FIXTURES) | (names & WAITING)


@pytest.mark.parametrize("folder", computing())
def test_tests_of_low_priority_wait_for_nothing(folder: str) -> None:
    files = sorted((REPOSITORY / "tests" / folder).rglob("*.py"))
    assert files
    # A command that says how long it took is no test.
    tests = [file for file in files if file.name != "__main__.py"]
    assert {str(file): names for file in tests if (names := waiting(file.read_text(encoding="utf-8")))} == {}


@pytest.mark.parametrize(
    ("program", "names"),
    [
        ("def test_a(process: str) -> None: ...", {"process"}),
        ("import time\nbegan = time.monotonic()", {"monotonic"}),
        ("wait_for(lambda: True, 'it')", {"wait_for"}),
        ("def test_a(tmp_path: Path) -> None: ...", set()),
    ],
)
def test_what_waits_is_noticed(program: str, names: set[str]) -> None:
    assert waiting(program) == names
