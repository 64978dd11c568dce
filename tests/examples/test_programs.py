"""Every program of clients/examples is run as a reader would, and does what its docstring says."""

import ast
import re
import subprocess
import sys
from pathlib import Path

import pytest

from tests.deploy.pages import REPOSITORY, page

EXAMPLES = REPOSITORY / "clients/examples"
PROGRAMS = sorted(EXAMPLES.glob("*.py"))
PUBLIC = {"voa_client", "voa_core", "voa_recordings", "voa_fleet", "voa_assets"}


def run(program: str, *arguments: str) -> str:
    """Run a program of the examples; return what it prints."""
    command = [sys.executable, str(EXAMPLES / program), *arguments]
    ended = subprocess.run(command, cwd=REPOSITORY, capture_output=True, text=True, check=False, timeout=120)
    assert ended.returncode == 0, ended.stderr
    return ended.stdout


def test_an_object_is_set_up(process: str) -> None:
    printed = run("set_up_an_object.py", process)
    assert "4 poses, 4 grasps" in printed
    assert "warning" not in printed
    assert printed.endswith("recommended: look\n")


def test_two_robots_share_a_session(process: str) -> None:
    printed = run("two_robots.py", process)
    announced, looked = printed.splitlines()[-2:]
    places = announced.removeprefix("announced ").removesuffix(" before the drives")
    assert looked == f"looked from {places}; OI90 succeeded"


def test_an_episode_runs_with_the_skeleton_of_a_real_device(process: str) -> None:
    printed = run("real_device.py", process)
    assert re.fullmatch(r"looked from \w+(, \w+)*; OI90, expected to succeed with 0\.\d\d: lifted\n", printed)


def test_an_experiment_is_recorded_and_replayed(process: str, tmp_path: Path) -> None:
    printed = run("recorded_experiment.py", str(tmp_path / "box"))
    assert "12 scans of 3 poses from 4 places" in printed
    command = [sys.executable, "-m", "voa_cli.main", "replay", str(tmp_path / "box"), "--url", process]
    replayed = subprocess.run(command, capture_output=True, text=True, check=False, timeout=120)
    assert replayed.returncode == 0, replayed.stderr
    assert "AECD" in replayed.stdout
    assert "over 228 beams" in replayed.stdout


def test_the_same_seed_records_the_same_experiment(tmp_path: Path) -> None:
    first, second = tmp_path / "first", tmp_path / "second"
    for folder in (first, second):
        run("recorded_experiment.py", str(folder))
    assert (first / "scans.csv").read_bytes() == (second / "scans.csv").read_bytes()


@pytest.mark.parametrize("program", PROGRAMS, ids=lambda path: path.name)
def test_a_program_uses_public_names_alone(program: Path) -> None:
    for node in ast.walk(ast.parse(program.read_text(encoding="utf-8"))):
        modules = [node.module or ""] if isinstance(node, ast.ImportFrom) else []
        modules += [alias.name for alias in node.names] if isinstance(node, ast.Import) else []
        for module in modules:
            first, *rest = module.split(".")
            assert not first.startswith("voa_") or first in PUBLIC, module
            assert not any(part.startswith("_") for part in rest), module


def test_the_quick_start_lists_every_program() -> None:
    listed = page("quick-start").text
    for program in [*PROGRAMS, *EXAMPLES.glob("*.ipynb")]:
        assert f"`clients/examples/{program.name}`" in listed
