"""A fault to be put into a copy of the tree, and what the tests say of it."""

import os
import re
import subprocess
import sys
from dataclasses import dataclass
from pathlib import Path

_PACKAGES = (".", "service", "clients", "assets")
_SECONDS = 600.0
_FAILED = re.compile(r"^(?:FAILED|ERROR) (.+?)(?: - (.*))?$", re.MULTILINE)


@dataclass(frozen=True)
class Mutant:
    """Change of the code that some test must detect.

    Attributes:
        name: what is wrong then.
        file: where, from the root of the repository.
        old: text that stands there once.
        new: what stands there instead.
        tests: files of tests, separated by blanks, or one test.
    """

    name: str
    file: str
    old: str
    new: str
    tests: str


@dataclass(frozen=True)
class Verdict:
    """Result of one mutant: "killed", "survived", or "stale" where the text to be replaced is gone."""

    outcome: str
    test: str = ""
    how: str = ""


def judge(mutant: Mutant, tree: Path) -> Verdict:
    """Put the fault into `tree`, run the tests that should notice, and take it out again."""
    path = tree / mutant.file
    before = path.read_text(encoding="utf-8")
    if before.count(mutant.old) != 1:
        return Verdict("stale", how=f"expected {mutant.old!r} once in {mutant.file}: renew the mutant")
    path.write_text(before.replace(mutant.old, mutant.new), encoding="utf-8")
    try:
        failed, output = tests_fail(mutant.tests, tree)
    finally:
        path.write_text(before, encoding="utf-8")
    if not failed:
        return Verdict("survived")
    match = _FAILED.search(output)
    return (
        Verdict("killed", *(part or "" for part in match.groups())) if match else Verdict("killed", how=output[-200:])
    )


def tests_fail(tests: str, tree: Path) -> tuple[bool, str]:
    """Run tests on the code in `tree`; returns True if one fails, and pytest's output."""
    # The kernels in Python: compiling them again for each mutant would take longer than all tests of the mathematics.
    plain = {"NUMBA_DISABLE_JIT": "1"} if all(name.startswith("tests/voa_core") for name in tests.split()) else {}
    paths = os.pathsep.join(str(tree / package) for package in _PACKAGES)
    done = subprocess.run(
        [sys.executable, "-m", "pytest", "-q", "-x", "-p", "no:cacheprovider", "--tb=no", *tests.split()],
        cwd=tree,
        env=os.environ | plain | {"PYTHONPATH": paths, "PYTHONDONTWRITEBYTECODE": "1", "COLUMNS": "400"},
        capture_output=True,
        text=True,
        timeout=_SECONDS,
        check=False,
    )
    if done.returncode not in (0, 1):
        raise RuntimeError(f"pytest could not run {tests}:\n{done.stdout}{done.stderr}")
    return done.returncode == 1, done.stdout
