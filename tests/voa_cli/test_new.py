"""`voa new`: options, the unit of the mesh, and what it prints."""

import io
import json
import sys
from collections.abc import Callable
from pathlib import Path

import pytest

from tests.support.meshes import box, written
from voa_cli.main import main
from voa_cli.new.command import with_scale
from voa_cli.new.options import choices_of, read_options
from voa_setup.choices import Choices
from voa_setup.setup import NewScenario, new_scenario
from voa_setup.writing import begun_folder


class Keyboard(io.StringIO):
    """A terminal at which a person types the given lines."""

    def isatty(self) -> bool:
        return True


@pytest.fixture
def mesh(tmp_path: Path) -> Path:
    return written(box(0.10, 0.04, 0.025), tmp_path / "part.stl")


def once(make: Callable[..., NewScenario]) -> Callable[..., NewScenario]:
    """The function, whose first result stands for all: a scenario takes seconds."""
    results: list[NewScenario] = []

    def made(*arguments: object) -> NewScenario:
        results.append(results[0] if results else make(*arguments))
        return results[0]

    return made


def choices(*arguments: str) -> Choices:
    return choices_of(read_options("", ["part.stl", *arguments]))


def test_options_become_choices(tmp_path: Path) -> None:
    plain = choices()
    assert list(plain.yaws_deg) == [45.0 * index for index in range(8)]
    assert (plain.places, plain.lidar, plain.height_m, plain.scores) == (8, "lds-02", None, "simulated")
    assert (plain.xy_m, plain.yaw_deg, plain.attempts, plain.gripper.opening_m) == (0.005, 3.0, 15, 0.085)
    assert list(choices("--yaws", "0,90").yaws_deg) == [0.0, 90.0]
    assert list(choices("--yaws", "30,").yaws_deg) == [30.0]
    assert choices("--positions", "0.1,0", "-0.1,0.05").positions == [(0.1, 0.0), (-0.1, 0.05)]
    assert choices("--gripper", "0.05").gripper.opening_m == 0.05
    assert choices("--rests", "upright", "on side A").rests == ["upright", "on side A"]
    listed = choices("--place", "E,0.5,0,180", "--place", "N,0,0.5,-90").places
    assert not isinstance(listed, int)
    assert [place.name for place in listed] == ["E", "N"]
    file = tmp_path / "places.csv"
    file.write_text("E,0.5,0,180\n")
    assert not isinstance(choices("--places", str(file)).places, int)
    assert read_options("", ["a/bottle.stl"]).out == Path("bottle")


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (["--gripper", "hand"], "--gripper: expected one of 2fg7"),
        (["--places", "0"], "expected a number from 1 to 360, or a file"),
        (["--places=-3"], "expected a number from 1 to 360, or a file"),
        (["--places", "none.csv"], "cannot be read as a list of places"),
        (["--places", "4", "--place", "E,0.5,0,180"], "not both"),
        (["--radius", "0.5", "--place", "E,0.5,0,180"], "leave it out where places are listed"),
        (["--scores", "none.csv"], "expected simulated, geometric, or a file"),
    ],
)
def test_options_that_contradict_are_2(
    mesh: Path, capsys: pytest.CaptureFixture[str], arguments: list[str], words: str
) -> None:
    assert main(["new", str(mesh), *arguments]) == 2
    out, err = capsys.readouterr()
    assert out == ""
    assert err.startswith("voa new: ")
    assert words in err


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (["--yaws", "0,360"], "different yaws in degrees"),
        (["--yaws", "x"], "such as 0,90,180"),
        (["--positions", "1"], "X,Y in metres"),
        (["--spread", "-1,3"], "metres and degrees"),
        (["--scale", "0"], "above 0"),
        (["--least-probability", "2"], "from 0 to 1"),
        (["--grasps", "0"], "at least 1"),
        (["--seed", "-1"], "whole number of at least 0"),
    ],
)
def test_values_that_cannot_be_read_are_refused(
    capsys: pytest.CaptureFixture[str], arguments: list[str], words: str
) -> None:
    with pytest.raises(SystemExit) as ended:
        main(["new", "part.stl", *arguments])
    assert ended.value.code == 2
    assert words in capsys.readouterr().err


def test_in_a_pipe_an_unlikely_size_is_refused_with_the_option(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(sys, "stdin", io.StringIO())
    file = written(box(100.0, 40.0, 25.0), tmp_path / "part.stl")
    assert main(["new", str(file), "-o", str(tmp_path / "part")]) == 1
    out, err = capsys.readouterr()
    assert out == ""
    assert "state --scale 0.001 if it is in millimetres (10 cm)" in err
    assert not (tmp_path / "part").exists()


def test_a_file_that_cannot_be_written_is_named(
    mesh: Path, process: str, capsys: pytest.CaptureFixture[str], tmp_path: Path
) -> None:
    (tmp_path / "out" / "part.obj").mkdir(parents=True)
    quick = ["--yaws", "1", "--grasps", "1", "--scores", "geometric", "--url", process]
    assert main(["new", str(mesh), *quick, "-o", str(tmp_path / "out")]) == 1
    assert f"voa new: {tmp_path}/out/part.obj cannot be written: Is a directory" in capsys.readouterr().err


def test_an_interruption_says_that_the_command_resumes(
    mesh: Path, process: str, capsys: pytest.CaptureFixture[str], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def interrupted(_client: object, _choices: Choices, folder: Path, _stages: object) -> NewScenario:
        begun_folder(folder)
        raise KeyboardInterrupt

    monkeypatch.setattr("voa_cli.new.command.new_scenario", interrupted)
    assert main(["new", str(mesh), "--url", process, "-o", str(tmp_path / "out")]) == 130
    assert "interrupted; the same command keeps the attempts that are finished" in capsys.readouterr().err


@pytest.mark.parametrize(("typed", "scale"), [("\n", 0.001), ("x\n-1\n0.002\n", 0.002)])
def test_at_a_terminal_the_unit_is_requested(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch, typed: str, scale: float
) -> None:
    monkeypatch.setattr(sys, "stdin", Keyboard(typed))
    monkeypatch.setattr(sys.stderr, "isatty", lambda: True, raising=False)
    file = written(box(100.0, 40.0, 25.0), tmp_path / "part.stl")
    assert with_scale(Choices(file)).scale == scale
    assert "metres per unit of the file [0.001]: " in capsys.readouterr().err


def test_the_result_is_printed_for_a_person_and_as_json(
    mesh: Path,
    process: str,
    capfd: pytest.CaptureFixture[str],
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    folder = tmp_path / "out"
    monkeypatch.setattr("voa_cli.new.command.new_scenario", once(new_scenario))
    few = [
        "--yaws",
        "0,90",
        "--grasps",
        "2",
        "--least-probability",
        "0.5",
        "--scores",
        "geometric",
        "--url",
        process,
        "-o",
        str(folder),
    ]
    assert main(["new", str(mesh), *few]) == 0
    out, err = capfd.readouterr()
    assert err == ""
    assert f"{folder}: " in out
    ending = out[out.index("Next:") :].splitlines()
    assert [line[:2] for line in ending[1:]] == ["1.", "2.", "3."]
    assert f"open {folder}/look.html" in ending[1]
    assert f"voa demo --object {folder}" in ending[2]
    assert main(["new", str(mesh), *few, "--json"]) == 0
    out, err = capfd.readouterr()
    assert err == ""
    report = json.loads(out)
    assert report["warnings"] == []
    assert report["page"] == f"{folder}/look.html"
    assert len(report["ranking"]["ranking"]) == len(report["places"]) == 8
