"""The plan of the house, held against the folders: sizes, maps in docstrings, and who may know whom."""

import ast
import re
from pathlib import Path

import pytest

from tests.architecture.test_imports import PACKAGES, REPOSITORY, files_of, imported

LARGEST_SHARE = 0.22
MAPPING = "mapping"


def lines_of(package: str) -> int:
    return sum(len(path.read_text().splitlines()) for path in files_of(REPOSITORY / PACKAGES[package].folder))


def test_each_package_holds_less_than_22_per_cent_of_the_source() -> None:
    sizes = {name: lines_of(name) for name in PACKAGES}
    total = sum(sizes.values())
    shares = {name: round(size / total, 3) for name, size in sizes.items()}
    assert max(shares.values()) < LARGEST_SHARE, shares


def test_nobody_imports_the_command_line() -> None:
    users = [
        f"{path.relative_to(REPOSITORY)}: {dotted}"
        for name, package in PACKAGES.items()
        if name != "voa_cli"
        for path in files_of(REPOSITORY / package.folder)
        for dotted in sorted(imported(path.read_text()))
        if dotted.split(".")[0] == "voa_cli"
    ]
    assert not users


def test_only_the_mapping_knows_messages_and_mathematics() -> None:
    folder = REPOSITORY / PACKAGES["voa_service"].folder
    both = [
        path.relative_to(folder).as_posix()
        for path in files_of(folder)
        if {"voa_core", "voa_msgs"} <= {dotted.split(".")[0] for dotted in imported(path.read_text())}
        and path.relative_to(folder).parts[0] != MAPPING
    ]
    assert not both, "messages become mathematics, and results messages, in voa_service/mapping alone"


def test_modules_of_the_client_are_private() -> None:
    """Names of the client, and messages that a robot needs, come from `voa_client` itself."""
    users = [
        f"{path.relative_to(REPOSITORY)}: {dotted}"
        for name, package in PACKAGES.items()
        if name != "voa_client"
        for path in files_of(REPOSITORY / package.folder)
        for dotted in sorted(imported(path.read_text()))
        if dotted.startswith("voa_client._")
    ]
    assert not users


def folders() -> list[Path]:
    return [REPOSITORY / package.folder for package in PACKAGES.values()]


NAMES_MODULES = {"file", "folder", "module", "part", "see", "folder or file", "file or folder"}
"""Headers of the columns that name modules and folders, in the tables of docstrings of packages."""


def tables(docstring: str) -> set[str]:
    """Names of modules and folders that the tables of a docstring list; empty where no table does."""
    listed: set[str] = set()
    columns: list[int] = []
    for line in docstring.splitlines():
        cells = [cell.strip() for cell in line.strip("|").split("|")] if line.startswith("|") else []
        if not cells:
            columns = []
        elif not columns:
            columns = [index for index, cell in enumerate(cells) if cell in NAMES_MODULES]
            if not columns:
                columns = [-1]
        elif columns != [-1]:
            listed |= {name for index in columns for name in re.findall(r"`([a-z_0-9./]+)`", cells[index])}
    return {name.strip("/").removeprefix("voa_client.") for name in listed}


def with_map() -> list[Path]:
    """Packages and their folders whose docstring has a table of modules."""
    every = [path for folder in folders() for path in sorted(folder.rglob("__init__.py"))]
    return [path for path in every if tables(ast.get_docstring(ast.parse(path.read_text())) or "")]


@pytest.mark.parametrize("package", with_map(), ids=lambda path: path.parent.relative_to(REPOSITORY).as_posix())
def test_the_map_in_the_docstring_is_the_folder(package: Path) -> None:
    docstring = ast.get_docstring(ast.parse(package.read_text())) or ""
    folder = package.parent
    gone = {
        name for name in tables(docstring) if not (folder / name).is_dir() and not (folder / f"{name}.py").is_file()
    }
    assert not gone
    modules = {path.stem for path in folder.glob("*.py") if not path.stem.startswith("_")}
    modules |= {path.parent.name for path in folder.glob("*/__init__.py")}
    unnamed = {name for name in modules if not re.search(rf"`([a-z_]+\.)?{name}/?`", docstring)}
    assert not unnamed


def test_maps_are_held_wherever_there_is_one() -> None:
    held = {path.parent.relative_to(REPOSITORY).as_posix() for path in with_map()}
    assert held >= {"voa_core", "voa_core/rules", "clients/voa_ros", "clients/voa_fleet", "service/voa_service"}
    assert held >= {"service/voa_service/http", "service/voa_service/zenoh", "clients/voa_fleet/episodes"}


def test_files_can_be_read_in_one_sitting() -> None:
    longest = 330
    long = {
        path.relative_to(REPOSITORY).as_posix(): lines
        for package in PACKAGES.values()
        for path in files_of(REPOSITORY / package.folder)
        if (lines := len(path.read_text().splitlines())) > longest
    }
    assert not long


def test_every_module_says_what_it_is_for() -> None:
    silent = [
        path.relative_to(REPOSITORY).as_posix()
        for package in PACKAGES.values()
        for path in files_of(REPOSITORY / package.folder)
        if not ast.get_docstring(ast.parse(path.read_text())) and path.read_text().strip()
    ]
    assert not silent


def test_the_tests_mirror_the_packages() -> None:
    """Folders of tests that are named after a package have no folder of a module that is not there."""
    wrong = []
    for name, package in PACKAGES.items():
        tests, source = REPOSITORY / "tests" / name, REPOSITORY / package.folder
        for path in sorted(tests.rglob("test_*.py")):
            inside = path.relative_to(tests).parent
            if not (source / inside).is_dir():
                wrong.append(path.relative_to(REPOSITORY).as_posix())
    assert not wrong


def test_every_package_is_typed() -> None:
    assert not [folder.name for folder in folders() if not (folder / "py.typed").is_file()]
