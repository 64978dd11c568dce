"""No text of the project advises to install `voa` from a package index, where another project has that name."""

import re
from pathlib import Path

import pytest

from voa_client.installing import install_hint

REPOSITORY = Path(__file__).resolve().parents[2]
FROM_AN_INDEX = re.compile(
    r"""\b(?:pip3?|pipx|uv|uvx|conda|poetry)\ (?:[\w.-]+\ )*?(?:install|add)\b   # a command that installs
        [^\n]*?[\s'"`]voa(?![\w/-])                                             # `voa`, `voa[cli]`, `voa==1`
      | ['"`]voa\[[\w,{]                                                         # 'voa[cli]', wherever it stands
    """,
    re.VERBOSE,
)
PARTS = (
    *("CHANGELOG.md", "CONTRIBUTING.md", "Makefile", "README.md"),
    *("assets", "clients", "deploy", "service", "tests", "voa_core"),
)
"""Texts that people read or run; not pyproject.toml, whose extras refer to each other where an installer finds them."""


def texts() -> dict[str, str]:
    below = (file for part in PARTS for file in (REPOSITORY / part, *(REPOSITORY / part).rglob("*")))
    read = {str(file.relative_to(REPOSITORY)): file.read_bytes() for file in below if file.is_file()}
    own = str(Path(__file__).relative_to(REPOSITORY))
    return {name: data.decode() for name, data in read.items() if name != own and b"\0" not in data}


def test_nothing_suggests_a_package_of_an_index() -> None:
    read = texts()
    assert {"README.md", "clients/voa_cli/main.py"} <= read.keys()
    commands = [f"{name}: {match[0]}" for name, text in read.items() for match in FROM_AN_INDEX.finditer(text)]
    assert commands == [], "expected voa_client.installing.install_hint"


@pytest.mark.parametrize(
    "text",
    [
        "pip install voa",
        "pip install 'voa[cli]'",
        "pip install --upgrade voa\n",
        'pip3 install "voa==1.0"',
        "python -m pip install -q voa.",
        "uv pip install voa[cli]",
        "uv add voa",
        "it needs 'voa[fleet]'",
        "f\"'voa[{extra}]'\"",
    ],
)
def test_what_would_is_recognised(text: str) -> None:
    assert FROM_AN_INDEX.search(text)


@pytest.mark.parametrize(
    "text",
    [
        *(install_hint(extra) for extra in ("", "cli")),
        "pip install '.[zenoh]'",
        "pip install glfw",
        "pip install -e . && voa/run",
        "the `voa` command",
        "voa[sensor.name]",
        "pip install ./voa-1.0.whl",
    ],
)
def test_what_would_not_is_not(text: str) -> None:
    assert not FROM_AN_INDEX.search(text)
