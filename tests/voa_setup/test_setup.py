"""A scenario from a mesh, whole: files that the service, the fleet and a person can use, and the same each time."""

from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest

from tests.support.meshes import box, written
from voa_client import Client
from voa_fleet.episodes.priors import prior_of
from voa_fleet.world.objects import read_object
from voa_msgs.grasp_geometry import grasp_geometry
from voa_msgs.scenarios import GivenScores, MeasuredScores
from voa_setup.choices import GEOMETRIC, SIMULATED, Choices
from voa_setup.errors import InvalidOption, SetupError, UnusableFolder
from voa_setup.grasps.proposals import NoGrasp
from voa_setup.grippers import gripper_named
from voa_setup.scores.table import InvalidScores
from voa_setup.scoring import without_failures
from voa_setup.setup import NewScenario, new_scenario


class Quiet:
    """Steps that nobody watches."""

    def __init__(self) -> None:
        self.steps: list[str] = []
        self.progress: list[tuple[int, int]] = []

    def begin(self, text: str) -> None:
        self.steps.append(text)

    def advance(self, done: int, total: int) -> None:
        self.progress.append((done, total))


FILES = {"scenario.json", "physics.json", "hulls.obj", "part.obj", "scores.csv", "look.html"}


@pytest.fixture(scope="module")
def choices(tmp_path_factory: pytest.TempPathFactory) -> Choices:
    file = written(box(0.10, 0.04, 0.025), tmp_path_factory.mktemp("meshes") / "part.stl")
    return Choices(file, yaws_deg=(0.0, 90.0), grasps=3, least_probability=0.5, scores=GEOMETRIC, seed=3)


@pytest.fixture(scope="module")
def made(process: str, choices: Choices, tmp_path_factory: pytest.TempPathFactory) -> NewScenario:
    with Client(process) as client:
        return new_scenario(client, choices, tmp_path_factory.mktemp("new") / "part", Quiet())


def test_the_folder_has_all_files_and_the_service_has_no_warning(made: NewScenario) -> None:
    assert {file.name for file in made.folder.iterdir()} == FILES
    assert made.warnings == []
    assert {look.sensor for look in made.ranking.ranking} == {place.name for place in made.scenario.sensors}
    assert any("first guess" in note for note in made.notes)
    assert any(note.startswith("The scan plane is") for note in made.notes)
    assert all(note.endswith(".") for note in made.notes)


def test_the_fleet_reads_the_folder_as_it_was_made(made: NewScenario) -> None:
    target = read_object(made.folder)
    assert target.poses == [pose.name for pose in made.scenario.poses]
    assert prior_of(target) == pytest.approx(made.scenario.prior, abs=1e-6)
    assert isinstance(made.scenario.scores, GivenScores)
    for grasp in made.scenario.grasps:
        geometry = grasp_geometry(grasp.data)
        assert geometry is not None
        assert target.grasp(grasp.name) == geometry
    assert all(any(row) for row in made.scenario.scores.probabilities)


def test_equal_choices_give_equal_files(made: NewScenario, process: str, choices: Choices, tmp_path: Path) -> None:
    with Client(process) as client:
        again = new_scenario(client, choices, tmp_path / "again", Quiet())
    for name in FILES:
        assert (again.folder / name).read_bytes() == (made.folder / name).read_bytes(), name


def test_simulated_scores_count_successes(process: str, choices: Choices, tmp_path: Path) -> None:
    few = replace(choices, scores=SIMULATED, attempts=1, processes=1, yaws_deg=(0.0,), grasps=1)
    stages = Quiet()
    with Client(process) as client:
        made = new_scenario(client, few, tmp_path / "part", stages)
    assert isinstance(made.scenario.scores, MeasuredScores)
    assert made.scenario.scores.attempts == 1
    cells = len(made.scenario.poses)
    assert stages.progress[-1] == (cells, cells)
    assert {file.name for file in made.folder.iterdir()} == FILES
    assert "scoring the grasps" in stages.steps


def test_a_table_that_a_lab_filled_becomes_the_scores(
    made: NewScenario, process: str, choices: Choices, tmp_path: Path
) -> None:
    lines = (made.folder / "scores.csv").read_text().splitlines()
    filled = [lines[0], *(line.removesuffix(",,") + ",7,10" for line in lines[1:])]
    table = tmp_path / "filled.csv"
    table.write_text("\n".join(filled))
    with Client(process) as client:
        measured = new_scenario(client, replace(choices, scores=table), tmp_path / "part", Quiet())
        assert isinstance(measured.scenario.scores, MeasuredScores)
        assert {count for row in measured.scenario.scores.successes for count in row} == {7}
        assert (measured.folder / "scores.csv").read_bytes() == table.read_bytes()


def test_what_is_there_is_not_written_over(made: NewScenario, process: str, choices: Choices) -> None:
    before = (made.folder / "scenario.json").read_bytes()
    with Client(process) as client:
        with pytest.raises(UnusableFolder, match="add --force to write over it"):
            new_scenario(client, choices, made.folder, Quiet())
        obj = made.folder / "part.obj"
        with pytest.raises(UnusableFolder, match="would be written over: choose another folder"):
            new_scenario(client, replace(choices, mesh=obj, force=True), made.folder, Quiet())
        with pytest.raises(InvalidOption, match=r"no such lidar; there are: .*lds-02"):
            new_scenario(client, replace(choices, lidar="sonar", force=True), made.folder, Quiet())
    assert (made.folder / "scenario.json").read_bytes() == before


@pytest.mark.parametrize(
    "unusable",
    [
        {"height_m": 5.0},
        {"radius_m": 0.01},
        {"lidar": "sonar"},
        {"gripper": gripper_named("0.02")},
        {"positions": ((5.0, 0.0),), "places": 1},
        {"scores": Path("none.csv")},
    ],
    ids=lambda change: next(iter(change)),
)
def test_a_refusal_leaves_no_files(process: str, choices: Choices, tmp_path: Path, unusable: dict[str, Any]) -> None:
    folder = tmp_path / "new"
    with Client(process) as client, pytest.raises((SetupError, NoGrasp, InvalidScores)):
        new_scenario(client, replace(choices, **unusable), folder, Quiet())
    assert not folder.exists()


def test_a_folder_that_cannot_be_used_is_refused_before_the_work(
    process: str, choices: Choices, tmp_path: Path
) -> None:
    (tmp_path / "file").write_text("")
    stages = Quiet()
    with Client(process) as client:
        for folder in (tmp_path / "file", tmp_path / "file" / "below"):
            with pytest.raises(UnusableFolder, match="file is a file, where a folder is expected"):
                new_scenario(client, choices, folder, stages)
    assert set(stages.steps) == {"reading the mesh"}


def test_an_interrupted_folder_is_written_over_without_force(
    made: NewScenario, process: str, choices: Choices, tmp_path: Path
) -> None:
    class Interrupted(Quiet):
        def begin(self, text: str) -> None:
            if text == "checking the scenario and ranking its places":
                raise KeyboardInterrupt

    folder = tmp_path / "part"
    with Client(process) as client:
        with pytest.raises(KeyboardInterrupt):
            new_scenario(client, choices, folder, Interrupted())
        assert (folder / "scenario.json").exists()
        new_scenario(client, choices, folder, Quiet())
    assert {file.name: file.read_bytes() for file in folder.iterdir()} == {
        file.name: file.read_bytes() for file in made.folder.iterdir()
    }


def test_grasps_that_succeed_at_no_pose_are_left_out_unless_all_fail(made: NewScenario) -> None:
    poses, grasps = len(made.scenario.poses), [grasp.name for grasp in made.scenario.grasps]
    rows = [[0] * poses, *[[3] * poses] * (len(grasps) - 1)]
    counted = made.scenario.model_copy(update={"scores": MeasuredScores(attempts=5, successes=rows)})
    changed, notes = without_failures(counted)
    assert [grasp.name for grasp in changed.grasps] == grasps[1:]
    assert changed.scores == MeasuredScores(attempts=5, successes=rows[1:])
    assert notes == [f"Left out because they succeed at no pose: {grasps[0]}."]
    failing = counted.model_copy(update={"scores": MeasuredScores(attempts=5, successes=[[0] * poses] * len(grasps))})
    assert without_failures(failing) == (failing, [])
