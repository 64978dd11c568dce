"""`voa evaluate voa`: tables on the terminal, CSV files and one JSON document."""

import json
from dataclasses import replace
from pathlib import Path

import pytest

from voa_cli.evaluate import command as evaluate
from voa_evaluation.values.setting import QUICK, ROBOT_ERRORS
from voa_evaluation.values.tables import TABLES


@pytest.fixture(autouse=True)
def tiny(monkeypatch: pytest.MonkeyPatch) -> None:
    """Evaluate so little that it takes seconds, and in this process: others would not see the change."""
    setting = replace(QUICK, scans=8, beliefs=2, sessions=3, drops=1, rules=("beam",), robot_errors=ROBOT_ERRORS[1:2])
    monkeypatch.setattr("voa_cli.evaluate.values.QUICK", setting)


def test_tables_fit_the_terminal_and_name_every_file(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    arguments = ["voa", "block", "--quick", "--processes", "1", "--out", str(tmp_path)]
    assert evaluate.main(arguments) == 0
    printed = capsys.readouterr().out
    assert "A trial run (--quick)" in printed
    assert "…" not in printed
    assert max(len(line) for line in printed.splitlines() if str(tmp_path) not in line) <= 80
    for title in ("One look", "Promised less achieved", "Sessions of several looks", "driving costs", "Two robots"):
        assert title in printed
    assert "Robot error 1 cm, 1 deg, rule beam: success" in " ".join(printed.split())
    named = {line.rpartition(": ")[2] for line in printed.splitlines() if str(tmp_path) in line}
    assert named == {str(file) for file in tmp_path.iterdir() if file.suffix != ".png"}  # pictures are in the page


def test_the_document_is_that_of_the_file_whatever_the_number_of_processes(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    documents = []
    for processes in ("1", "2"):
        out = tmp_path / processes
        arguments = ["voa", "--object", "block", "--quick", "--seed", "4", "--processes", processes, "--json"]
        assert evaluate.main([*arguments, "--out", str(out)]) == 0
        printed = capsys.readouterr()
        assert printed.err == ""
        documents.append(json.loads(printed.out))
        assert json.loads((out / "values.json").read_text(encoding="utf-8")) == documents[-1]
    assert documents[0] == documents[1]
    assert set(documents[0]) == {"setting", "counts", *TABLES}
    assert documents[0]["setting"]["seed"] == 4
    assert documents[0]["counts"]["objects"] == ["block"]


def test_an_unknown_object_is_refused(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert evaluate.main(["voa", "teapot", "--out", str(tmp_path)]) == 1
    assert "no object 'teapot'; there are: mug, mallet, block" in capsys.readouterr().err
