"""`voa rank` with a scenario file, a belief, a session."""

import json
import math
from datetime import UTC, datetime
from pathlib import Path
from typing import Any

import pytest

from tests.support.serving import box_obj, changed, data_scenario, mesh_scenario
from voa_assets import path as asset
from voa_cli.main import main
from voa_client import Client, InvalidRequestError
from voa_client import _calls as calls
from voa_client.scenario_files import load_scenario, load_with_warnings
from voa_msgs.objects import Object, ObjectPage, UpAxis
from voa_msgs.problems import Problem
from voa_msgs.scenarios import Scenario, ScenarioRequest
from voa_msgs.sessions import SessionRequest


@pytest.fixture
def file(tmp_path: Path) -> Path:
    path = tmp_path / "scenario.json"
    path.write_text(json.dumps(data_scenario()), encoding="utf-8")
    return path


def ranked(capfd: pytest.CaptureFixture[str], *arguments: str) -> Any:
    assert main(["rank", *arguments, "--json"]) == 0
    out, err = capfd.readouterr()
    assert err == ""
    return json.loads(out)


def test_a_file_a_belief_and_a_session_give_the_same_ranking(
    capfd: pytest.CaptureFixture[str], process: str, file: Path
) -> None:
    belief = [0.2, 0.3, 0.5]
    beside = file.with_name("belief.json")
    beside.write_text(json.dumps({"belief": belief}), encoding="utf-8")
    with Client(process) as client:
        scenario = client.create_scenario(ScenarioRequest.model_validate(data_scenario()))
        session = client.create_session(SessionRequest(scenario=scenario.id, prior=belief))
    found = [
        ranked(capfd, str(file), "--belief", "0.2,0.3,0.5", "--url", process),
        ranked(capfd, str(file), "--belief", str(beside), "--url", process),
        ranked(capfd, "--session", session.id, "--url", process),
    ]
    assert [ranking.pop("version") for ranking in found] == [None, None, 0]
    assert found[0] == found[1] == found[2]
    assert {look["sensor"] for look in found[0]["ranking"]} == {"Q1", "Q2"}


def test_without_a_belief_it_is_the_scenario_s_prior(
    capfd: pytest.CaptureFixture[str], process: str, file: Path
) -> None:
    uniform = ranked(capfd, str(file), "--belief", ",".join([str(1 / 3)] * 3), "--url", process)
    own = ranked(capfd, str(file), "--url", process)
    assert own["expected_score_before"] == pytest.approx(uniform["expected_score_before"])
    voa = [{look["sensor"]: look["voa"] for look in ranking["ranking"]} for ranking in (own, uniform)]
    assert voa[0] == pytest.approx(voa[1])


def test_definition_and_grasps_are_passed_on(capfd: pytest.CaptureFixture[str], process: str, file: Path) -> None:
    ranking = ranked(capfd, str(file), "--definition", "executed", "--grasps", "G2", "--url", process)
    assert (ranking["definition"], ranking["best_grasp_before"]) == ("executed", "G2")


@pytest.mark.parametrize("prior", [None, [0.6, 0.3, 0.1]])
def test_ranking_a_file_leaves_no_session_and_equals_a_session_s_ranking(
    capfd: pytest.CaptureFixture[str], process: str, tmp_path: Path, prior: list[float] | None
) -> None:
    path = tmp_path / "scenario.json"
    path.write_text(json.dumps(data_scenario(name="left behind", prior=prior)), encoding="utf-8")
    own = ranked(capfd, str(path), "--url", process)
    with Client(process) as client:
        [scenario] = [each.id for each in client.list_scenarios() if each.name == "left behind"][-1:]
        assert scenario not in [session.scenario for session in client.list_sessions()]
        session = client.create_session(SessionRequest(scenario=scenario)).id
        of_session = json.loads(client.rank_looks(session).model_dump_json(exclude_unset=True))
    assert own == of_session | {"version": None}


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


def values(capfd: pytest.CaptureFixture[str], process: str, path: Path, *more: str) -> dict[str, float]:
    """VOA by place."""
    assert main(["rank", str(path), "--url", process, "--json", *more]) == 0
    return {look["sensor"]: look["voa"] for look in json.loads(capfd.readouterr().out)["ranking"]}


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
    """A client that notes what it is asked to upload."""

    def __init__(self) -> None:
        super().__init__("http://127.0.0.1:9")
        self.told: list[tuple[str, float, str | None]] = []
        self.sent: list[ScenarioRequest] = []

    def find_object(self, mesh: Path, scale: float = 1.0, up: UpAxis | None = None) -> Object | None:
        return None

    def create_object(
        self, mesh: Path, name: str | None = None, scale: float = 1.0, up: UpAxis | None = None
    ) -> Object:
        self.told.append((mesh.name, scale, up))
        size, made = [0.04, 0.06, 0.05], datetime.now(UTC)
        return Object(id="f" * 64, name=mesh.stem, extents=size, faces=12, watertight=True, created_at=made)

    def create_scenario(self, request: ScenarioRequest) -> Scenario:
        self.sent.append(request)
        return Scenario.model_validate(request.model_dump() | {"id": "e" * 64, "created_at": datetime.now(UTC)})


@pytest.mark.parametrize(
    ("beside", "told"),
    [
        ({}, (1.0, None)),
        ({"scale": 0.001}, (0.001, None)),
        ({"up": "+Y"}, (1.0, "+Y")),
        ({"up": "+Z", "scale": 2}, (2.0, "+Z")),
        ({"up": None, "scale": None}, (1.0, None)),
    ],
)
def test_scale_and_up_are_the_mesh_s_and_not_sent_with_the_scenario(
    tmp_path: Path, beside: dict[str, Any], told: tuple[float, str | None]
) -> None:
    plain = mesh_scenario("box.obj")
    path = written(tmp_path / "scenario.json", plain | beside, box_obj())
    with Uploads() as client:
        load_scenario(client, path)
        assert client.told == [("box.obj", *told)]
        assert client.sent == [ScenarioRequest.model_validate(plain | {"object": "f" * 64})]


def test_a_byte_order_mark_does_no_harm(capfd: pytest.CaptureFixture[str], process: str, file: Path) -> None:
    marked = file.with_name("marked.json")
    marked.write_bytes(b"\xef\xbb\xbf" + file.read_bytes())
    belief = file.with_name("belief.json")
    belief.write_bytes(b"\xef\xbb\xbf[0.2, 0.3, 0.5]")
    assert values(capfd, process, marked) == values(capfd, process, file)
    assert values(capfd, process, marked, "--belief", str(belief))


def test_a_person_reads_a_table(capfd: pytest.CaptureFixture[str], process: str) -> None:
    assert main(["rank", str(asset("mug/scenario.json")), "--url", process]) == 0
    out = capfd.readouterr().out
    assert "best grasp without a look: TD90, expected score 0.400" in out
    assert "0 to 0.155" in out
    assert "look from ENE first: its net value +0.155 is more than min_gain 0.005" in out
    assert max(map(len, out.splitlines())) <= 80


@pytest.mark.parametrize("name", ["mug", "mallet", "block"])
def test_under_a_certain_belief_no_look_is_shown_as_worth_anything(
    capfd: pytest.CaptureFixture[str], process: str, name: str
) -> None:
    path = asset(f"{name}/scenario.json")
    belief = [1.0, *[0.0] * (len(json.loads(path.read_bytes())["poses"]) - 1)]
    assert main(["rank", str(path), "--belief", ",".join(map(str, belief)), "--url", process]) == 0
    out = capfd.readouterr().out
    assert "+0.000" not in out
    assert "look from" not in out
    assert "now, expected score" in " ".join(out.split())
    assert "(all: 0)" in " ".join(out.split())
    rows = [line for line in out.splitlines() if line.startswith("│")]
    assert [row.split()[1] for row in rows] == ["=1"] * len(rows)
    assert "█" not in out


def test_a_small_gain_is_grasped_and_a_scenario_may_ask_for_less(
    capfd: pytest.CaptureFixture[str], process: str, tmp_path: Path
) -> None:
    told = json.loads(asset("mug/scenario.json").read_bytes())
    told["object"] = str(asset("mug/mug.obj"))
    for min_gain, says in (
        (0.005, "no look's net value is more than min_gain 0.005"),
        (0.001, "is more than min_gain 0.001"),
    ):
        (tmp_path / "scenario.json").write_text(json.dumps(told | {"min_gain": min_gain}), encoding="utf-8")
        arguments = [str(tmp_path / "scenario.json"), "--belief", "0.995,0,0.005,0,0,0", "--url", process]
        assert main(["rank", *arguments]) == 0
        assert says in " ".join(capfd.readouterr().out.split())


def test_costs_fit_80_columns_and_names_in_brackets_are_printed(
    capfd: pytest.CaptureFixture[str], process: str, tmp_path: Path
) -> None:
    told = json.loads(asset("block/scenario.json").read_bytes())
    told["object"] = str(asset("block/block.obj"))
    for index, sensor in enumerate(told["sensors"]):
        sensor |= {"cost": 0.03 * index, "name": f"[{sensor['name']}]"}
    (tmp_path / "scenario.json").write_text(json.dumps(told), encoding="utf-8")
    assert main(["rank", str(tmp_path / "scenario.json"), "--url", process]) == 0
    out = capfd.readouterr().out
    assert max(map(len, out.splitlines())) <= 80
    assert "│ [NNE]  │ +0.169 │ █" in out
    assert "│ 0.030 │    +0.139 │" in out
    assert "look from [NNE] first: its net value +0.139" in out


@pytest.mark.parametrize(("columns", "bars"), [(60, False), (72, False), (74, True), (100, True)])
def test_bars_are_drawn_where_a_line_has_room_beside_whole_figures(
    capfd: pytest.CaptureFixture[str],
    process: str,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    columns: int,
    bars: bool,
) -> None:
    monkeypatch.setenv("COLUMNS", str(columns))
    told = json.loads(asset("block/scenario.json").read_bytes())
    told["object"] = str(asset("block/block.obj"))
    told["sensors"][0]["cost"] = 0.01
    (tmp_path / "scenario.json").write_text(json.dumps(told), encoding="utf-8")
    assert main(["rank", str(tmp_path / "scenario.json"), "--url", process]) == 0
    out = capfd.readouterr().out
    assert max(map(len, out.splitlines())) <= columns
    assert "…" not in out
    assert ("█" in out) is bars


def test_a_session_s_ranking_is_explained_by_its_scenario(
    capfd: pytest.CaptureFixture[str], process: str, file: Path
) -> None:
    told = json.loads(file.read_bytes()) | {"min_gain": 0.9}
    with Client(process) as client:
        scenario = client.create_scenario(ScenarioRequest.model_validate(told))
        session = client.create_session(SessionRequest(scenario=scenario.id))
    assert main(["rank", "--session", session.id, "--url", process]) == 0
    assert "no look's net value is more than min_gain 0.9" in " ".join(capfd.readouterr().out.split())


@pytest.mark.parametrize(
    "arguments", [[], ["a.json", "--session", "s"], ["--session", "s"], ["--session", "s", "--belief", "1"]]
)
def test_what_does_not_go_together_is_a_usage_error(arguments: list[str], capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit) as ended:
        main(["rank", *arguments])
    assert ended.value.code == 2
    assert "usage: voa rank" in capsys.readouterr().err


@pytest.mark.parametrize(
    ("content", "says"),
    [
        (None, "No such file"),
        ("{", "not JSON: Expecting"),
        ("[]", "expected an object with fields, got a list"),
        (json.dumps(data_scenario(posse=[])), "posse: no such field: expected one of name, object, poses, "),
        (json.dumps(data_scenario(scael=1)), ", prior, scale, up"),
        (json.dumps(changed(data_scenario(), "poses.0.nmae", "x")), "nmae: no such field: expected one of name, posi"),
        (json.dumps(changed(data_scenario(), "predictions.Q1.P1.0", math.nan)), "in predictions, null for no return"),
        (json.dumps(data_scenario(object="box.obj", scale=0)), "scale: "),
        (json.dumps(data_scenario(object="box.obj", up="Y")), "up: "),
        (json.dumps(data_scenario(scale=0.001)), "scale: needs a mesh file as `object`"),
        (json.dumps(data_scenario(object="f" * 64, up="+Y")), "up: needs a mesh file as `object`"),
        (json.dumps(data_scenario(object="..")), "there is no mesh file"),
        ('{"name": "a"}', "poses"),
        (json.dumps(data_scenario(object="missing.obj")), "there is no mesh file"),
        (b"\xff\xfe", "scenario.json"),
    ],
)
def test_a_scenario_file_that_is_wrong_is_said_so(
    capfd: pytest.CaptureFixture[str], process: str, tmp_path: Path, content: str | bytes | None, says: str
) -> None:
    path = tmp_path / "scenario.json"
    if content is not None:
        path.write_bytes(content if isinstance(content, bytes) else content.encode())
    assert main(["rank", str(path), "--url", process]) == 1
    out, err = capfd.readouterr()
    assert out == ""
    assert err.startswith("voa rank: ")
    assert says in err
    assert err.count("\n") == 1


@pytest.mark.parametrize("belief", ["a,b,c", "", "0.5;0.5", "gone.json", "."])
def test_a_belief_that_is_none_is_said_so(
    capfd: pytest.CaptureFixture[str], process: str, file: Path, belief: str
) -> None:
    assert main(["rank", str(file), "--url", process, "--belief", belief]) == 1
    assert "--belief: expected" in capfd.readouterr().err


def test_a_belief_of_no_numbers_is_said_in_one_line(
    capfd: pytest.CaptureFixture[str], process: str, file: Path
) -> None:
    assert main(["rank", str(file), "--url", process, "--belief", "nan,0.5,0.5"]) == 1
    (line,) = capfd.readouterr().err.splitlines()
    assert line.startswith("voa rank: belief.0: expected a finite number, got nan")


def test_a_belief_that_does_not_sum_to_1_is_refused_by_the_service(
    capfd: pytest.CaptureFixture[str], process: str, file: Path
) -> None:
    assert main(["rank", str(file), "--url", process, "--belief", "0.1,0.1,0.1"]) == 1
    assert "within 1e-6 of 1" in capfd.readouterr().err
