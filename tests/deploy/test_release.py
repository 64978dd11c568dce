"""The release is the same wherever it is stated, and the files beside the code can be used."""

import re
import tomllib
from datetime import date
from typing import Any

import pytest
from ruamel.yaml import YAML

from tests.deploy.pages import REPOSITORY

YAML_FILES = ["CITATION.cff", ".pre-commit-config.yaml"]


def read(path: str) -> str:
    return (REPOSITORY / path).read_text(encoding="utf-8")


def loaded(path: str) -> dict[str, Any]:
    document: dict[str, Any] = YAML(typ="safe").load(read(path))
    return document


def releases() -> list[tuple[str, str]]:
    """Releases of the changelog with their dates, the newest first."""
    return re.findall(r"(?m)^## \[(\d+\.\d+\.\d+)\] - (\d{4}-\d{2}-\d{2})$", read("CHANGELOG.md"))


def test_the_newest_release_of_the_changelog_is_the_package() -> None:
    version = tomllib.loads(read("pyproject.toml"))["project"]["version"]
    newest, when = releases()[0]
    assert newest == version
    assert date.fromisoformat(when) <= date(2100, 1, 1)


def test_releases_descend_and_unreleased_stands_first() -> None:
    headings = re.findall(r"(?m)^## \[(.*?)\]", read("CHANGELOG.md"))
    assert headings[0] == "Unreleased"
    numbers = [tuple(map(int, version.split("."))) for version, _ in releases()]
    assert headings[1:] == [version for version, _ in releases()]
    assert numbers == sorted(numbers, reverse=True)


def test_image_and_citation_state_the_same_release() -> None:
    newest, when = releases()[0]
    assert f"ARG VERSION={newest}\n" in read("deploy/Dockerfile")
    citation = loaded("CITATION.cff")
    assert (str(citation["version"]), str(citation["date-released"])) == (newest, when)
    assert citation["cff-version"] == "1.2.0"
    assert {"message", "title", "authors"} <= set(citation)


def test_hooks_call_locked_tools_alone() -> None:
    locked = set(re.findall(r"(?m)^([a-z0-9-]+)==", read("requirements.lock")))
    (repository,) = loaded(".pre-commit-config.yaml")["repos"]
    assert repository["repo"] == "local", (
        "another repository would be downloaded, and its tools are not the locked ones"
    )
    for hook in repository["hooks"]:
        command, *arguments = hook["entry"].split()
        assert hook["language"] == "system"
        tool = arguments[1] if command == ".venv/bin/python" else command.removeprefix(".venv/bin/")
        assert tool in locked, hook["entry"]


@pytest.mark.parametrize("path", YAML_FILES)
def test_files_of_the_root_are_yaml(path: str) -> None:
    assert loaded(path)
