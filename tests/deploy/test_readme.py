"""Mappings, links, folders, calls and options that the README shows exist."""

import json
import re

import pytest
import zenoh

from tests.deploy.readme import README, REPOSITORY, Command, agrees, blocks, commands, mentioned
from tests.support.serving import Service
from voa_cli.main import main
from voa_core.rules.registry import RULES
from voa_ros.robots import load

METHODS = re.compile(r"`(GET|POST|PUT|DELETE) ([^`?]+)[^`]*`|`(/[^`?{}]*)`")


def test_the_mapping_is_one() -> None:
    (mapping,) = blocks("toml")
    (robot,) = load(mapping.text)
    assert [each.topic for each in robot.subscriptions] == ["tb3_1/scan", "tb3_1/odom"]
    assert robot.look.scans == 10


def test_the_bridges_configuration_can_be_read() -> None:
    (bridge,) = blocks("json5")
    read = json.loads(zenoh.Config.from_json5(bridge.text).get_json("plugins"))
    assert read["ros2dds"]["allow"]["publishers"] == ["/scan", "/odom", "/amcl_pose"]


def test_links_lead_somewhere() -> None:
    for target in re.findall(r"\]\(((?!http)[^)#]+)\)", README):
        assert (REPOSITORY / target).exists(), target


def test_the_folders_are_there() -> None:
    (tree,) = (block.text for block in blocks("") if block.text.startswith("voa_core/"))
    for line in tree.splitlines():
        assert (REPOSITORY / line.split()[0]).is_dir(), line


def test_the_targets_are_there() -> None:
    targets = re.findall(r"(?m)^([a-z]+):", (REPOSITORY / "Makefile").read_text(encoding="utf-8"))
    assert set(re.findall(r"`make ([a-z]+)`|^make ([a-z]+)$", README, re.MULTILINE)) <= {
        pair for target in targets for pair in ((target, ""), ("", target))
    }


def test_the_calls_are_there(service: Service) -> None:
    paths = service.get("/openapi.json")["paths"]
    there = {(method.upper(), path) for path, methods in paths.items() for method in methods}
    found = [match.groups() for match in METHODS.finditer(README)]
    assert len(found) > 8
    for method, path, alone in found:
        for each in [alone] if alone else path.split(", "):
            if alone in ("/docs", "/openapi.json"):
                assert service.http.get(alone).is_success
            else:
                assert any(
                    re.fullmatch(re.sub(r"\\{\w+\\}", r"[^/]+", re.escape(known)), each)
                    for way, known in there
                    if method in (None, way)
                ), f"{method} {each}"


def test_the_rules_are_there() -> None:
    (table,) = re.findall(r"## Update rules\n\n(.*?)\n\n", README, re.DOTALL)
    named = [name for row in table.splitlines()[2:] for name in re.findall(r"`(\w+)`", row.split("|")[1])]
    assert sorted(named) == sorted(RULES)


@pytest.mark.parametrize("command", [*commands(), *mentioned()], ids=lambda command: command.line[:60])
def test_the_options_are_there(command: Command, capsys: pytest.CaptureFixture[str]) -> None:
    name, *rest = command.words
    assert name == "voa"
    sub = [word for word in rest[:2] if re.fullmatch(r"[a-z][a-z-]*", word)]
    with pytest.raises(SystemExit) as ended:
        main([*sub, "--help"])
    assert ended.value.code == 0
    told = capsys.readouterr().out
    for word in rest:
        if word.startswith("-"):
            assert re.search(rf"(?<![\w-]){word}\b", told), word


def test_what_is_printed_agrees_with_what_is_stated_but_for_ids_and_what_is_left_out() -> None:
    printed = "one 0123456789abcdef\n\n  two 0.5\n  three\n"
    assert agrees(["one fedcba9876543210", "  two 0.5", "  three"], printed)
    assert agrees(["one fedcba9876543210", "   ...", "  three"], printed)
    assert agrees(["...", "  two 0.5", "..."], printed)
    for stated in (["one fedcba9876543210", "  three"], ["...", "  two 0.6", "..."], ["...", "  two 0.5"], ["one 1"]):
        assert not agrees(stated, printed)
