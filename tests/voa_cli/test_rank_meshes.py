"""`voa rank` with mesh files: uploaded once, with their scale and axis."""

import json
from datetime import UTC, datetime
from pathlib import Path
from typing import Any

import pytest

from tests.support.serving import box_obj, mesh_scenario
from tests.voa_cli.rankings import ranked, values
from voa_cli.main import main
from voa_client import Client, InvalidRequestError
from voa_client import _calls as calls
from voa_client.scenario_files import load_scenario, load_with_warnings
from voa_msgs.objects import Object, ObjectPage, UpAxis
from voa_msgs.problems import Problem
from voa_msgs.scenarios import Scenario, ScenarioRequest


class Noted(Client):
    """A client of a service that notes which meshes it uploads."""

    def __init__(self, url: str) -> None:
        super().__init__(url)
        self.uploaded: list[str] = []

    def create_object(
        self, mesh: Path, name: str | None = None, scale: float = 1.0, up: UpAxis | None = None
    ) -> Object:
        self.uploaded.append(mesh.name)
        return super().create_object(mesh, name, scale, up)


def test_a_mesh_that_is_there_is_not_uploaded_and_warned_of_all_the_same(process: str, tmp_path: Path) -> None:
    mesh = box_obj(0.041, 0.062, 0.053)
    plain = written(tmp_path / "plain.json", mesh_scenario("box.obj"), mesh)
    scaled = written(tmp_path / "scaled.json", mesh_scenario("box.obj", scale=100), mesh)
    with Noted(process) as client:
        first, warned = load_with_warnings(client, plain), load_with_warnings(client, scaled)
        assert client.uploaded == ["box.obj", "box.obj"], "another scale is another object"
        assert "extent" in [warning.kind for warning in warned[1]]
        assert (load_with_warnings(client, plain), load_with_warnings(client, scaled)) == (first, warned)
        assert client.uploaded == ["box.obj", "box.obj"]
        written(plain, mesh_scenario("box.obj"), box_obj(0.042, 0.062, 0.053))
        assert load_with_warnings(client, plain)[0].object != first[0].object
        assert len(client.uploaded) == 3


def test_a_folder_stands_for_its_scenario_file(process: str, tmp_path: Path, capfd: pytest.CaptureFixture[str]) -> None:
    file = written(tmp_path / "scenario.json", mesh_scenario("box.obj"), box_obj())
    assert values(capfd, process, tmp_path) == values(capfd, process, file)
    file.unlink()
    assert main(["rank", str(tmp_path), "--url", process]) == 1
    assert f"{file}: No such file" in capfd.readouterr().err


class Old(Noted):
    """A client of a service that knows no question for a file: it refuses it, or lists what it has."""

    def __init__(self, url: str, lists: bool) -> None:
        super().__init__(url)
        self.lists = lists

    def find_object(self, mesh: Path, scale: float = 1.0, up: UpAxis | None = None) -> Object | None:
        if not self.lists:
            problem = Problem(type="urn:voa:problem:invalid-request", title="", status=422, detail="no such field")
            raise InvalidRequestError(problem)
        call = calls.find_object(mesh.name, mesh.read_bytes(), scale, up)
        return calls.matching_object(call, ObjectPage(items=list(self.list_objects()), next=None))


@pytest.mark.parametrize("lists", [True, False])
def test_an_older_service_is_sent_the_mesh(process: str, tmp_path: Path, lists: bool) -> None:
    path = written(tmp_path / "scenario.json", mesh_scenario("box.obj"), box_obj())
    with Old(process, lists) as client:
        scenario = load_scenario(client, path)
        assert load_scenario(client, path) == scenario
        assert client.uploaded == ["box.obj", "box.obj"]


def test_a_mesh_beside_the_file_is_uploaded(capfd: pytest.CaptureFixture[str], process: str, tmp_path: Path) -> None:
    (tmp_path / "box.obj").write_text(box_obj(), encoding="utf-8")
    (tmp_path / "scenario.json").write_text(json.dumps(mesh_scenario("box.obj")), encoding="utf-8")
    ranking = ranked(capfd, str(tmp_path / "scenario.json"), "--url", process)
    assert {look["sensor"] for look in ranking["ranking"]} == {"E", "N"}


def written(path: Path, scenario: dict[str, Any], mesh: str) -> Path:
    path.with_name(str(scenario["object"])).write_text(mesh, encoding="utf-8")
    path.write_text(json.dumps(scenario), encoding="utf-8")
    return path


def test_a_mesh_in_millimetres_is_read_by_its_scale_and_the_hint_says_where(
    capfd: pytest.CaptureFixture[str], process: str, tmp_path: Path
) -> None:
    in_metres = written(tmp_path / "metres.json", mesh_scenario("metres.obj"), box_obj(0.04, 0.06, 0.25))
    mesh = box_obj(40.0, 60.0, 250.0)
    unscaled = written(tmp_path / "unscaled.json", mesh_scenario("box.obj"), mesh)
    assert main(["rank", str(unscaled), "--url", process]) == 1
    (line,) = capfd.readouterr().err.splitlines()
    assert line.startswith(f"voa rank: {unscaled}: object: {unscaled.with_name('box.obj')}: expected an object of")
    assert line.endswith('(in unscaled.json, put "scale" beside "object")')
    scaled = written(tmp_path / "scaled.json", mesh_scenario("box.obj", scale=0.001), mesh)
    assert values(capfd, process, scaled) == pytest.approx(values(capfd, process, in_metres), abs=1e-9)


class Uploads(Client):
    """A client that records its uploads."""

    def __init__(self) -> None:
        super().__init__("http://127.0.0.1:9")
        self.uploads: list[tuple[str, float, str | None]] = []
        self.sent: list[ScenarioRequest] = []

    def find_object(self, mesh: Path, scale: float = 1.0, up: UpAxis | None = None) -> Object | None:
        return None

    def create_object(
        self, mesh: Path, name: str | None = None, scale: float = 1.0, up: UpAxis | None = None
    ) -> Object:
        self.uploads.append((mesh.name, scale, up))
        size, made = [0.04, 0.06, 0.05], datetime.now(UTC)
        return Object(id="f" * 64, name=mesh.stem, extents=size, faces=12, watertight=True, created_at=made)

    def create_scenario(self, request: ScenarioRequest) -> Scenario:
        self.sent.append(request)
        return Scenario.model_validate(request.model_dump() | {"id": "e" * 64, "created_at": datetime.now(UTC)})


@pytest.mark.parametrize(
    ("beside", "document"),
    [
        ({}, (1.0, None)),
        ({"scale": 0.001}, (0.001, None)),
        ({"up": "+Y"}, (1.0, "+Y")),
        ({"up": "+Z", "scale": 2}, (2.0, "+Z")),
        ({"up": None, "scale": None}, (1.0, None)),
    ],
)
def test_scale_and_up_are_the_mesh_s_and_not_sent_with_the_scenario(
    tmp_path: Path, beside: dict[str, Any], document: tuple[float, str | None]
) -> None:
    plain = mesh_scenario("box.obj")
    path = written(tmp_path / "scenario.json", plain | beside, box_obj())
    with Uploads() as client:
        load_scenario(client, path)
        assert client.uploads == [("box.obj", *document)]
        assert client.sent == [ScenarioRequest.model_validate(plain | {"object": "f" * 64})]
