"""README.md and the documentation name only existing files, links, calls, commands, options, settings and problems."""

import json
import re
import tomllib
from collections.abc import Iterator
from pathlib import Path

import pytest
import zenoh
from pydantic import BaseModel

from tests.architecture.test_language import retired
from tests.deploy.pages import PAGES, README, REPOSITORY, Command, Page, agrees, page
from tests.support.serving import Service
from voa_cli.main import main
from voa_client import ScanRequest, ScenarioRequest
from voa_client.scenario_files import ScenarioFile
from voa_msgs.lidars import Lidar
from voa_ros.robots import load
from voa_service.failures import Failure, HttpError
from voa_service.settings import Settings

METHODS = re.compile(r"`(GET|POST|PUT|DELETE) ([^`?]+)[^`]*`|`(/[a-z][^`?{}]*)`")
PATHS = re.compile(r"`((?:voa_core|service|clients|assets|deploy|tests)/[\w./-]*)`")
COMMANDS = {command.line: command for each in PAGES for command in [*each.commands(), *each.mentioned()]}


def by_path(each: Page) -> str:
    return each.path


def test_the_mapping_is_one() -> None:
    (mapping,) = page("on-your-robots").blocks("toml")
    (robot,) = load(mapping.text)
    assert [each.topic for each in robot.subscriptions] == ["tb3_1/scan", "tb3_1/odom"]
    assert robot.look.scans == 10


def test_the_bridges_configuration_can_be_read() -> None:
    (bridge,) = page("on-your-robots").blocks("json5")
    read = json.loads(zenoh.Config.from_json5(bridge.text).get_json("plugins"))
    assert read["ros2dds"]["allow"]["publishers"] == ["/scan", "/odom", "/amcl_pose"]


@pytest.mark.parametrize("each", PAGES, ids=by_path)
def test_links_lead_somewhere(each: Page) -> None:
    folder = (REPOSITORY / each.path).parent
    for target in re.findall(r"\]\(((?!http)[^)#]+)", each.text):
        if target.startswith("api-"):
            continue  # made from docstrings
        assert (folder / target).exists(), target


@pytest.mark.parametrize("each", PAGES, ids=by_path)
def test_named_files_and_folders_exist(each: Page) -> None:
    for path in PATHS.findall(each.text):
        assert (REPOSITORY / path).exists(), path


BUILD_FILES = [
    REPOSITORY / "Makefile",
    *sorted(
        path
        for pattern in ("deploy/Dockerfile", "deploy/*.sh", "deploy/*.yml", "deploy/*.cfg", "assets/**/README.md")
        for path in REPOSITORY.glob(pattern)
    ),
]
"""Texts beside the pages and the code: build files and descriptions of data."""
WITH_RETIRED_WORDS = {"deploy/docs/glossary.md"}
"""Pages that list the retired words."""


@pytest.mark.parametrize(
    "path",
    [*(REPOSITORY / each.path for each in PAGES if each.path not in WITH_RETIRED_WORDS), *BUILD_FILES],
    ids=lambda path: path.relative_to(REPOSITORY).as_posix(),
)
def test_no_retired_word_is_used(path: Path) -> None:
    words = "|".join(word for word, only_in_names in retired().items() if not only_in_names)
    lines = path.read_text(encoding="utf-8").splitlines()
    assert [line for line in lines if re.search(rf"\b({words})\b", line, re.IGNORECASE)] == []


def test_the_scenarios_and_the_scan_are_valid_requests() -> None:
    (own,) = page("set-up-an-object").blocks("json")
    assert ScenarioFile.model_validate_json(own.text).object == "box.obj"
    scenario, scan = page("contract").blocks("json")
    stored = json.loads(scenario.text.replace("<object id or null>", "0" * 64))
    assert ScenarioRequest.model_validate(stored).lidar.preset == "lds-01"
    assert ScanRequest.model_validate_json(scan.text).scan.no_return == [2]
    (lidar,) = page("add-a-lidar").blocks("json")
    assert Lidar.model_validate_json(lidar.text.split(":", 1)[1]).beams == 720


def test_the_folders_of_the_house_exist() -> None:
    (tree,) = (block.text for block in page("where-is-what").blocks("") if block.text.startswith("voa_core/"))
    listed = [line.split()[0] for line in tree.splitlines()]
    for folder in listed:
        assert (REPOSITORY / folder).is_dir(), folder
    packages = tomllib.loads((REPOSITORY / "pyproject.toml").read_text())["tool"]["hatch"]["build"]["targets"]["wheel"]
    assert {f"{package}/" for package in packages["packages"]} <= set(listed)


def test_the_targets_exist() -> None:
    targets = set(re.findall(r"(?m)^([a-z]+):", (REPOSITORY / "Makefile").read_text(encoding="utf-8")))
    pattern = re.compile(r"`make ([a-z]+)`|^ *make ([a-z]+)$", re.MULTILINE)
    named = {name for each in PAGES for pair in pattern.findall(each.text) for name in pair if name}
    assert {"demo", "docs", "bench"} <= named <= targets


@pytest.fixture(scope="module")
def operations(service: Service) -> set[tuple[str, str]]:
    """Method and path of every call of the OpenAPI document."""
    paths = service.get("/openapi.json")["paths"]
    return {(method.upper(), path) for path, methods in paths.items() for method in methods}


def named_calls(each: Page) -> Iterator[tuple[str | None, str]]:
    """Every call that a page names, with its method where the page gives one."""
    for method, paths, alone in METHODS.findall(each.text):
        for path in [alone] if alone else paths.split(", "):
            yield method or None, path


def planned_calls() -> set[tuple[str | None, str]]:
    """Calls that the page of plans lists as new."""
    _, _, section = page("planned").text.partition("### New calls\n")
    return {(method or None, path) for method, path, _ in METHODS.findall(section.split("### ")[0]) if method}


def test_a_planned_call_is_not_built(operations: set[tuple[str, str]]) -> None:
    """A call that has been built leaves the page of plans, and is described by the contract."""
    assert not planned_calls() & operations


@pytest.mark.parametrize("each", PAGES, ids=by_path)
def test_named_calls_exist(each: Page, service: Service, operations: set[tuple[str, str]]) -> None:
    planned = planned_calls() if each.path == page("planned").path else set()
    for method, path in named_calls(each):
        if (method, path) in planned:
            continue
        if path in ("/", "/docs", "/openapi.json"):
            assert service.http.get(path).is_success
            continue
        if method is None and path.count("/") == 1 and path not in {known for _, known in operations}:
            continue  # a ROS topic or the like
        assert any(
            re.fullmatch(re.sub(r"\\{\w+\\}", r"[^/]+", re.escape(known)), path)
            for way, known in operations
            if method in (None, way)
        ), f"{method} {path}"


def test_the_contract_lists_every_call(operations: set[tuple[str, str]]) -> None:
    listed = set(named_calls(page("contract")))
    assert {call for call in operations if call not in listed} == set()


def test_the_mathematics_lists_every_rule(service: Service) -> None:
    (table,) = re.findall(r"## Update rules\n\n(.*?)\n\n", page("mathematics").text, re.DOTALL)
    named = [re.findall(r"`(\w+)`", row.split("|")[1])[0] for row in table.splitlines()[2:]]
    update = service.get("/openapi.json")["components"]["schemas"]["ScenarioRequest"]["properties"]["update"]
    assert set(named) == set(update["discriminator"]["mapping"]) - {"plugin"}


def settings_of(model: type[BaseModel], prefix: str) -> Iterator[tuple[str, object]]:
    """The name of each variable of the environment, with its default."""
    for name, field in model.model_fields.items():
        if isinstance(field.annotation, type) and issubclass(field.annotation, BaseModel):
            yield from settings_of(field.annotation, f"{prefix}{name.upper()}__")
        else:
            yield f"{prefix}{name.upper()}", field.default


def test_operations_list_every_setting_with_its_default() -> None:
    rows = dict(re.findall(r"(?m)^\| `(VOA_\w+)` \| ([^|]*) \|", page("operations").text))
    known = dict(settings_of(Settings, "VOA_"))
    assert set(rows) == set(known)
    for name, default in known.items():
        if default is None or default == () or isinstance(default, list):
            continue
        if isinstance(default, bool):
            assert rows[name] == str(default).lower(), name
        elif isinstance(default, int | float):
            assert float(rows[name]) == default, name
        else:
            assert rows[name] == str(default), name


def failures(kind: type[Failure] = Failure) -> Iterator[type[Failure]]:
    """Every class of failure that can reach a caller."""
    for each in kind.__subclasses__():
        if each.__module__.startswith("voa_service") and hasattr(each, "kind"):
            yield each
        yield from failures(each)


def test_troubleshooting_explains_every_kind_of_problem() -> None:
    rows = re.findall(r"(?m)^\| (\d+|any) \| `([a-z-]+)` \|", page("troubleshooting").text)
    explained = {kind: status for status, kind in rows}
    assert len(explained) == len(rows)
    assert explained == {each.kind: "any" if each is HttpError else str(each.status) for each in failures()}


def test_troubleshooting_explains_every_reason(service: Service) -> None:
    report = service.get("/openapi.json")["components"]["schemas"]["UpdateReport"]["properties"]["reason"]
    (reasons,) = [each["enum"] for each in report["anyOf"] if "enum" in each]
    for reason in reasons:
        assert f"`{reason}`" in page("troubleshooting").text


@pytest.mark.parametrize("command", COMMANDS.values(), ids=lambda command: command.line[:60])
def test_named_options_exist(command: Command, capsys: pytest.CaptureFixture[str]) -> None:
    name, *rest = command.words
    assert name == "voa"
    sub = [word for word in rest[:2] if re.fullmatch(r"[a-z][a-z-]*", word)]
    if rest[:1] == ["--version"]:
        return
    with pytest.raises(SystemExit) as ended:
        main([*sub, "--help"])
    assert ended.value.code == 0
    printed = capsys.readouterr().out
    for word in rest:
        if word.startswith("-"):
            assert re.search(rf"(?<![\w-]){word}\b", printed), word


def test_the_readme_is_a_page() -> None:
    assert len(README.text.splitlines()) <= 110


def test_printed_lines_agree_with_stated_ones_but_for_ids_and_omissions() -> None:
    printed = "one 0123456789abcdef\n\n  two 0.5\n  three\n"
    assert agrees(["one fedcba9876543210", "  two 0.5", "  three"], printed)
    assert agrees(["one fedcba9876543210", "   ...", "  three"], printed)
    assert agrees(["...", "  two 0.5", "..."], printed)
    for stated in (["one fedcba9876543210", "  three"], ["...", "  two 0.6", "..."], ["...", "  two 0.5"], ["one 1"]):
        assert not agrees(stated, printed)
