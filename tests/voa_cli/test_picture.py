"""Pictures of rankings and sessions, by the commands that draw them."""

import json
import re
from pathlib import Path

import pytest

from tests.support.serving import changed, data_scenario
from voa_assets import path as asset_path
from voa_cli.main import main
from voa_cli.picture import PictureNotWritten, draw_session
from voa_client import Client
from voa_client.scenario_files import load_scenario
from voa_msgs.geometry import Spread
from voa_msgs.looks import LookAnnouncement
from voa_msgs.scenarios import ScenarioRequest
from voa_msgs.sessions import Scan, ScanRequest, SessionRequest

PNG = b"\x89PNG"
MUG = asset_path("mug")


def texts(file: Path) -> list[str]:
    """Texts of an SVG file, which stand as comments before their outlines."""
    return [text.strip() for text in re.findall(r"<!-- (.*?) -->", file.read_text(encoding="utf-8"), re.DOTALL)]


@pytest.fixture
def file(tmp_path: Path) -> Path:
    path = tmp_path / "scenario.json"
    path.write_text(json.dumps(data_scenario()), encoding="utf-8")
    return path


@pytest.fixture
def session(process: str) -> str:
    """A session on the mug with a look from a listed place, and another under way from elsewhere."""
    with Client(process) as client:
        scenario = load_scenario(client, MUG / "scenario.json", spread=Spread(xy_m=0.005, yaw_rad=0.05))
        own = client.create_session(SessionRequest(scenario=scenario.id)).id
        ranges = client.predict(scenario.id).ranges[0][1]
        nothing = [index for index, value in enumerate(ranges) if value is None]
        client.apply_scan(own, ScanRequest(sensor="ENE", scan=Scan(ranges=ranges, no_return=nothing)))
        stand = {"x": 0.3, "y": -0.1, "yaw_rad": 3.0}
        client.announce_look(own, LookAnnouncement.model_validate({"sensor_pose": stand, "robot": "tb3_1"}))
    return own


def test_a_ranking_is_drawn_with_places_values_and_the_recommendation(process: str, tmp_path: Path) -> None:
    picture = tmp_path / "ranking.svg"
    assert main(["rank", str(MUG), "--scans", "simulated", "--url", process, "--picture", str(picture)]) == 0
    drawn = texts(picture)
    assert drawn.count("ENE") == 2  # on the map, and beside its bar
    assert any(re.fullmatch(r"=1: \+0\.3\d\d ± 0\.\d\d\d", text) for text in drawn)
    assert any(text.startswith("look from ENE first: its net value") for text in drawn)
    assert "mug: where to look (without a look: TD90, 0.40)" in drawn


def test_the_ranking_of_a_session_is_drawn(process: str, session: str, tmp_path: Path) -> None:
    picture = tmp_path / "ranking.png"
    assert main(["rank", "--session", session, "--scans", "exact", "--url", process, "--picture", str(picture)]) == 0
    assert picture.read_bytes().startswith(PNG)


@pytest.mark.parametrize("ending", ["png", "svg"])
def test_the_same_ranking_gives_the_same_bytes(process: str, file: Path, ending: str) -> None:
    pictures = [file.with_name(f"{name}.{ending}") for name in ("a", "b")]
    for picture in pictures:
        assert main(["rank", str(file), "--url", process, "--picture", str(picture)]) == 0
    assert pictures[0].read_bytes() == pictures[1].read_bytes()


def test_json_stays_one_document(process: str, file: Path, capfd: pytest.CaptureFixture[str]) -> None:
    picture = file.with_name("a.png")
    assert main(["rank", str(file), "--url", process, "--json", "--picture", str(picture)]) == 0
    assert "ranking" in json.loads(capfd.readouterr().out)
    assert picture.is_file()


@pytest.mark.parametrize(
    "prior",
    [
        [1.0, 0.0, 0.0],
        pytest.param(None, id="uniform"),
    ],
)
def test_the_prior_decides_how_dark_a_pose_is(process: str, file: Path, prior: list[float] | None) -> None:
    file.write_text(json.dumps(data_scenario(prior=prior)), encoding="utf-8")
    picture = file.with_name("a.svg")
    assert main(["rank", str(file), "--url", process, "--picture", str(picture)]) == 0
    opacities = set(re.findall(r"<use [^>]*fill-opacity: ([\d.]+)", picture.read_text(encoding="utf-8")))
    assert opacities == (set() if prior else {f"{0.06 + 0.94 * (1 / 3) ** 0.5:.6f}".rstrip("0")})


def test_names_with_dollar_signs_and_of_any_length_are_drawn_as_they_are(process: str, file: Path) -> None:
    file.write_text(json.dumps(changed(data_scenario(name="$x_{1$"), "grasps.1.name", "$" * 100)), encoding="utf-8")
    picture = file.with_name("a.svg")
    assert main(["rank", str(file), "--url", process, "--picture", str(picture)]) == 0
    assert any(text.startswith("$x_{1$: where to look") for text in texts(picture))


def test_a_session_is_drawn_with_its_looks_and_belief(process: str, session: str, tmp_path: Path) -> None:
    picture = tmp_path / "session.svg"
    assert main(["sessions", "show", session, "--url", process, "--picture", str(picture)]) == 0
    drawn = texts(picture)
    assert {"ENE: 1 look", "under way tb3_1"} <= set(drawn)
    assert any(text.startswith(f"mug, session {session}, version 1: best grasp") for text in drawn)
    poses = [text for text in drawn if re.fullmatch(r"[UD]_\d+", text)]
    with Client(process) as client:
        known = client.get_session(session)
    by_belief = sorted(zip(known.belief, known.poses, strict=True), key=lambda both: -both[0])
    assert poses == [pose for _, pose in by_belief]


def test_an_unwritable_file_is_said_in_one_line(
    process: str, session: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    folder = tmp_path / "a.png"
    folder.mkdir()
    assert main(["sessions", "show", session, "--url", process, "--picture", str(folder)]) == 1
    out, err = capsys.readouterr()
    assert (out, err) == ("", f"voa sessions: --picture: cannot write {folder}: Is a directory\n")


def test_a_session_of_too_many_poses_is_drawn_without_the_object(process: str, tmp_path: Path) -> None:
    with Client(process) as client:
        scenario = client.create_scenario(ScenarioRequest.model_validate(data_scenario(absent=0.2)))
        session = client.create_session(SessionRequest(scenario=scenario.id))
    draw_session(tmp_path / "a.svg", scenario, session, None)
    drawn = texts(tmp_path / "a.svg")
    assert "object at none of the poses: probability 0.200" in drawn
    assert "the scenario has too many poses" in drawn
    with pytest.raises(PictureNotWritten, match="No such file"):
        draw_session(tmp_path / "gone" / "a.svg", scenario, session, None)
