"""The page on the way of a scan names files and functions that exist."""

import ast
import re
from pathlib import Path

import pytest

from tests.architecture.test_imports import REPOSITORY

PAGE = REPOSITORY / "deploy" / "docs" / "way-of-a-scan.md"
ROW = re.compile(r"^\| `(?P<file>[\w/.]+\.py)` \| `(?P<name>[\w.]+)` \| ", re.MULTILINE)
FILE = re.compile(r"`((?:service|clients)/[\w/]+\.py)`")


def defined(path: Path) -> set[str]:
    """Names of a module's functions and classes, and of their methods as `Class.method`."""
    names: set[str] = set()
    for node in ast.parse(path.read_text()).body:
        if isinstance(node, ast.FunctionDef | ast.AsyncFunctionDef | ast.ClassDef):
            names.add(node.name)
        if isinstance(node, ast.ClassDef):
            names |= {f"{node.name}.{each.name}" for each in node.body if hasattr(each, "name")}
    return names


def rows() -> list[tuple[str, str]]:
    return [(row["file"], row["name"]) for row in ROW.finditer(PAGE.read_text())]


def test_both_ways_are_described() -> None:
    assert len(rows()) > 25
    ends = [name for _, name in rows()]
    assert ends.count("Updates.apply_scan") == 2, "by HTTP and by CDR, each once"


@pytest.mark.parametrize("file", sorted(set(FILE.findall(PAGE.read_text()))))
def test_every_file_exists(file: str) -> None:
    assert (REPOSITORY / file).is_file()


@pytest.mark.parametrize(("file", "name"), rows())
def test_every_function_is_in_its_file(file: str, name: str) -> None:
    assert name in defined(REPOSITORY / file)


def test_functions_named_in_the_text_exist() -> None:
    """Names between backticks beside a file, as in "`Rpc.answer` in `service/voa_service/rpc/entry.py`"."""
    named = re.findall(r"`([\w.]+)` (?:in|of)\s+`((?:service|clients)/[\w/]+\.py)`", PAGE.read_text())
    assert len(named) >= 5
    assert not [(name, file) for name, file in named if name not in defined(REPOSITORY / file)]
