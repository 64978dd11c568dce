"""Every program and command of the pages that runs on any machine is run, and prints what the page says."""

import re
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from tests.deploy.pages import PAGES, README, REPOSITORY, Block, Command, agrees, page
from tests.support.scale import scaled
from tests.support.serving import as_scan
from voa_cli.main import main
from voa_client import ArmClient, Client
from voa_client.scenario_files import load_scenario
from voa_msgs.scenarios import PredictionsRequest
from voa_msgs.sessions import OutcomeRequest, Scan, SessionRequest

HERE = "http://127.0.0.1:8000"
MUG = Path("assets/voa_assets/mug/scenario.json")
LOCAL = list({each.line: each for page_ in PAGES for each in page_.commands() if each.is_local}.values())


@pytest.fixture(autouse=True)
def _from_the_root(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(REPOSITORY)
    monkeypatch.setenv("COLUMNS", "120")


def run(program: Block, url: str) -> dict[str, Any]:
    """Run a program of a page against a service, and return its names."""
    assert program.text.count(HERE) <= 1
    namespace: dict[str, Any] = {}
    exec(compile(program.text.replace(HERE, url), "page.md", "exec"), namespace)  # noqa: S102 - our own text
    return namespace


def test_every_program_and_most_commands_are_run() -> None:
    programs = {each.path: len(each.blocks("python")) for each in PAGES if each.blocks("python")}
    others = {"deploy/docs/own-rule.md", "deploy/docs/own-policy.md"}  # tested with their example packages
    docs = {"api-core": 1, "quick-start": 1, "on-your-robots": 3, "see-a-scenario": 1}
    expected = {"README.md": 1} | {f"deploy/docs/{name}.md": count for name, count in docs.items()}
    run_elsewhere = {"CONTRIBUTING.md"} | others
    assert {path: count for path, count in programs.items() if path not in run_elsewhere} == expected
    assert {command.words[1] for command in LOCAL} >= {"check", "rank", "fleet", "replay"}


def test_the_program_of_the_readme_prints_what_is_stated(process: str, capsys: pytest.CaptureFixture[str]) -> None:
    program = README.program("load_scenario")
    run(program, process)
    stated = re.match(r"\s*It prints `([^`]+)`", program.after)
    assert stated is not None, "README: expected what the program prints behind it: It prints `...`"
    assert capsys.readouterr().out == stated[1] + "\n"


def test_the_program_of_a_scenario_s_page_writes_it(tmp_path: Path) -> None:
    program = page("see-a-scenario").program("write_look")
    here = program.text.replace('Path(".")', f"Path({str(tmp_path)!r})")
    names: dict[str, Any] = {}
    exec(compile(here, "page.md", "exec"), names)  # noqa: S102 - our own text
    assert [names["page"]] == list(tmp_path.iterdir())
    assert "goblet: is it right?" in names["page"].read_text(encoding="utf-8")


@pytest.mark.parametrize(("name", "word"), [("quick-start", "load_scenario"), ("api-core", "rank_looks")])
def test_the_program_of_a_page_prints_what_is_stated(
    process: str, capsys: pytest.CaptureFixture[str], name: str, word: str
) -> None:
    program = page(name).program(word)
    run(program, process)
    stated = re.match(r"\s*It prints[^\n]*\n\n```\n(.*?)```", program.after, re.DOTALL)
    assert stated is not None, f"{name}: expected a block with what the program prints behind it"
    assert capsys.readouterr().out == stated[1]


def test_the_robots_program_looks_grasps_and_reports(process: str) -> None:
    look_and_grasp: Callable[..., None] = run(page("on-your-robots").program("look_and_grasp"), process)[
        "look_and_grasp"
    ]
    tried: list[str] = []
    stands: list[str] = []
    with Client(process) as client:
        scenario = load_scenario(client, MUG)
        session = client.create_session(SessionRequest(scenario=scenario.id)).id
        predicted = client.predict(scenario.id, PredictionsRequest())
        seen = {sensor: predicted.ranges[index][0] for index, sensor in enumerate(predicted.sensors)}

        def grasp(name: str) -> bool:
            tried.append(name)
            return True

        look_and_grasp(process, session, stands.append, lambda: Scan.model_validate(as_scan(seen[stands[-1]])), grasp)
        kinds = [entry.kind for entry in client.history(session)]
        outcome = OutcomeRequest.model_validate(list(client.history(session))[-1].request)
    assert kinds == ["prior", *["scan"] * len(stands), "outcome"]
    assert (len(stands) > 0, [outcome.grasp], outcome.success) == (True, tried, True)


def test_the_arms_program_moves_to_the_geometry_of_a_grasp(process: str) -> None:
    move_to: Callable[..., None] = run(page("on-your-robots").program("def move_to"), process)["move_to"]
    moves: list[tuple[tuple[float, ...], ...]] = []
    with Client(process) as client:
        scenario = load_scenario(client, MUG)
        session = client.create_session(SessionRequest(scenario=scenario.id)).id
        move_to(ArmClient(client, session), "OI90", lambda *move: moves.append(tuple(map(tuple, move))))
        geometry = ArmClient(client, session).geometry("OI90")
    assert geometry is not None
    before, there = moves
    assert there == (geometry.tool_centre_point, geometry.approach, geometry.closing)
    distance = [b - a for b, a in zip(there[0], before[0], strict=True)]
    assert distance == pytest.approx([0.1 * part for part in geometry.approach])


@pytest.mark.parametrize("command", LOCAL, ids=lambda command: command.line[:60])
def test_a_command_ends_well_and_prints_what_is_stated(command: Command, capfd: pytest.CaptureFixture[str]) -> None:
    assert main(command.words[1:]) == 0
    printed = capfd.readouterr().out
    assert printed.strip()
    if command.output:
        assert agrees(command.output, printed), printed


@pytest.mark.parametrize("object_", scaled(("mallet",), ("mallet", "mug", "block")))
def test_the_demo_prints_the_stated_story_and_counts_the_stated_grasps(
    object_: str, tmp_path: Path, capfd: pytest.CaptureFixture[str]
) -> None:
    assert main(["demo", "--out", str(tmp_path), "--object", object_]) == 0
    printed = capfd.readouterr().out
    assert _counts(printed) == _stated_counts(object_)
    if object_ == "mallet":
        (story,) = [block.text for block in README.blocks("") if "look from" in block.text]
        lines = [line for line in printed.splitlines() if re.match(r" *\d+\.\d s  ", line)]
        assert agrees([*story.splitlines(), "..."], "\n".join(lines)), printed


def _stated_counts(object_: str) -> tuple[int, ...]:
    """Numbers of grasps that succeed without looks, and with them, as the README states them."""
    words = {
        "mallet": r"without a look (\d+) of 20 grasps succeed, with up to three looks (\d+) of 20",
        "mug": r"`voa demo --object mug` it is (\d+) and (\d+) of 20",
        "block": r"with the block (\d+) and (\d+)\b",
    }
    stated = re.search(words[object_], " ".join(README.text.split()))
    assert stated is not None, f"README: expected how many grasps of the {object_} succeed, as {words[object_]!r}"
    return tuple(map(int, stated.groups()))


def _counts(printed: str) -> tuple[int, ...]:
    """Numbers of grasps that succeeded without looks, and with them, as the demo prints them."""
    failed = re.search(
        r"Without a look (\d+) of (\d+) grasps failed, with looks (\d+) of \2\.", " ".join(printed.split())
    )
    assert failed is not None
    return int(failed[2]) - int(failed[1]), int(failed[2]) - int(failed[3])
