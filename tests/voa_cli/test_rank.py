"""`voa rank` with a scenario file, a belief, a session."""

import json
import math
from pathlib import Path

import pytest

from tests.support.serving import changed, data_scenario
from tests.voa_cli.rankings import ranked, values
from voa_cli.main import main
from voa_client import Client
from voa_msgs.scenarios import ScenarioRequest
from voa_msgs.sessions import SessionRequest


@pytest.fixture
def file(tmp_path: Path) -> Path:
    path = tmp_path / "scenario.json"
    path.write_text(json.dumps(data_scenario()), encoding="utf-8")
    return path


def test_a_file_a_belief_and_a_session_give_the_same_ranking(
    capfd: pytest.CaptureFixture[str], process: str, file: Path
) -> None:
    belief = [0.2, 0.3, 0.5]
    beside = file.with_name("belief.json")
    beside.write_text(json.dumps({"belief": belief}), encoding="utf-8")
    with Client(process) as client:
        scenario = client.create_scenario(ScenarioRequest.model_validate(data_scenario()))
        session = client.create_session(SessionRequest(scenario=scenario.id, prior=belief))
    result = [
        ranked(capfd, str(file), "--belief", "0.2,0.3,0.5", "--url", process),
        ranked(capfd, str(file), "--belief", str(beside), "--url", process),
        ranked(capfd, "--session", session.id, "--url", process),
    ]
    assert [ranking.pop("version") for ranking in result] == [None, None, 0]
    assert result[0] == result[1] == result[2]
    assert {look["sensor"] for look in result[0]["ranking"]} == {"Q1", "Q2"}


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


def test_a_byte_order_mark_does_no_harm(capfd: pytest.CaptureFixture[str], process: str, file: Path) -> None:
    marked = file.with_name("marked.json")
    marked.write_bytes(b"\xef\xbb\xbf" + file.read_bytes())
    belief = file.with_name("belief.json")
    belief.write_bytes(b"\xef\xbb\xbf[0.2, 0.3, 0.5]")
    assert values(capfd, process, marked) == values(capfd, process, file)
    assert values(capfd, process, marked, "--belief", str(belief))


def test_a_session_s_ranking_is_explained_by_its_scenario(
    capfd: pytest.CaptureFixture[str], process: str, file: Path
) -> None:
    document = json.loads(file.read_bytes()) | {"min_gain": 0.9}
    with Client(process) as client:
        scenario = client.create_scenario(ScenarioRequest.model_validate(document))
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
        (
            json.dumps(changed(data_scenario(), "predictions.Q1.P1.0", math.nan)),
            "in predictions write null",
        ),
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
