"""The example of a policy: its package is installed as a user would, and both commands accept its policy."""

import csv
import json
import subprocess
import sys
from pathlib import Path
from typing import Any

import pytest

from tests.support.evaluations import FEW_SCANS
from voa_cli.evaluate import command as evaluate
from voa_cli.main import main
from voa_fleet.episodes.policies import POLICIES, description_of

EXAMPLE = Path(__file__).resolve().parents[2] / "clients" / "examples" / "own_policy"


@pytest.fixture(scope="module")
def installed(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder into which the package was installed."""
    folder = tmp_path_factory.mktemp("installed")
    command = [sys.executable, "-m", "pip", "install", "--quiet", "--disable-pip-version-check", "--no-deps"]
    command += ["--no-build-isolation", "--no-index", "--target", str(folder), str(EXAMPLE)]
    subprocess.run(command, check=True, timeout=120.0)
    return folder


@pytest.fixture
def on_the_path_of_python(installed: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.syspath_prepend(str(installed))


@pytest.mark.usefixtures("on_the_path_of_python")
def test_an_installed_policy_has_its_description() -> None:
    assert description_of("opposite").startswith("The look farthest from the robot")


@pytest.mark.usefixtures("on_the_path_of_python")
def test_the_fleet_uses_it(process: str, capfd: pytest.CaptureFixture[str]) -> None:
    assert main(["fleet", "--url", process, "--policy", "opposite", "--looks", "2", "--json"]) == 0
    documents: list[dict[str, Any]] = json.loads(capfd.readouterr().out)
    (document,) = documents
    assert document["policy"] == "opposite"
    first, second = (look["sensor"] for look in document["looks"])
    sides = {"N": "S", "S": "N", "E": "W", "W": "E"}
    assert second == "".join(sides[letter] for letter in first)


@pytest.mark.usefixtures("on_the_path_of_python")
def test_the_evaluation_compares_voa_with_it(
    process: str, tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("voa_cli.evaluate.values.QUICK", FEW_SCANS)
    options = ["--quick", "--drops", "1", "--attempts", "1", "--sensitivity-drops", "1", "--url", process]
    arguments = ["all", "block", *options, "--policy", "opposite", "--out", str(tmp_path), "--json"]
    assert evaluate.main(arguments) == 0
    document = json.loads(capsys.readouterr().out)
    assert {each["policy"] for each in document["voa"]["policies"]} == {*POLICIES, "opposite"}
    with (tmp_path / "voa-choices.csv").open(encoding="utf-8", newline="") as lines:
        rows = [row for row in csv.DictReader(lines) if row["policy"] == "opposite"]
    assert rows
    assert all(row["sensor"] != "none" for row in rows)


@pytest.mark.parametrize("command", [["fleet"], ["evaluate", "all", "block"]])
def test_where_it_is_not_installed_both_commands_list_the_others(
    command: list[str], process: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capfd: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    assert main([*command, "--url", process, "--policy", "opposite"]) == 1
    assert "no policy 'opposite'; there are: voa, entropy, beams, nearest, random, none" in capfd.readouterr().err
