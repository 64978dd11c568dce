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


TOPICS = {
    "voa_core/rules/test_built_in.py": "all built-in rules are compared by one set of properties",
    "voa_core/test_axioms.py": "laws that hold for the mathematics as a whole",
    "voa_core/test_lab_holder.py": "the lab's own scans, through the whole of the mathematics",
    "voa_ros/test_lidar_drivers.py": "messages of real lidar drivers, made by tests/support/lidar_drivers",
    "voa_ros/test_look_taker_repeats.py": "the look taker and repeated revolutions",
    "voa_ros/test_look_taker_scenes.py": "the look taker and scenes that change",
    "voa_ros/test_pipeline_clocks.py": "the pipeline and clocks that are wrong",
    "voa_client/test_bus.py": "followers on a bus where anybody may put anything",
    "voa_client/test_conformance.py": "one suite for every transport",
    "voa_client/test_events.py": "streams of events that a proxy has spoilt",
    "voa_client/test_hints.py": "hints of a bus or proxy that are checked with the service",
    "voa_client/test_surface.py": "the names of the package, sync and async",
    "voa_doctor/test_live_robots.py": "the doctor beside a real service and robot",
    "voa_cli/test_rank_meshes.py": "`voa rank` and mesh files",
    "voa_cli/test_record_latched.py": "`voa record` and publishers that keep their newest message",
    "voa_assets/test_access.py": "the package itself",
    "voa_assets/test_fleet_objects.py": "data: block, mallet, goblet and coupling",
    "voa_assets/test_lidars.py": "data: lidar presets",
    "voa_assets/test_mug_mesh.py": "data: the mug's mesh",
    "voa_assets/test_mug_scenario.py": "data: the mug's scenario",
    "voa_assets/test_recorded_mug.py": "data: the mug's recorded experiment",
    "voa_assets/test_scores.py": "data: grasp scores of goblet and coupling",
    "voa_assets/test_stories.py": "data: values of looks at goblet and coupling",
    "voa_meshes/test_glb_refusals.py": "GLB files that are refused",
    "voa_service/zenoh/test_claimed_robots.py": "mapped robots that are claimed while they drive, or have no session",
    "voa_service/zenoh/test_late_messages.py": "a process that works on the messages of robots late",
    "voa_store/test_after_kill.py": "the store after its process was killed",
    "voa_store/test_concurrency.py": "calls of several stores on one database at the same time",
    "voa_store/test_conformance.py": "one suite for every database",
    "voa_store/test_failures.py": "databases that are of another version, silent, full or locked",
    "voa_store/test_upgrades_while_running.py": "processes of the version before, while their database is migrated",
    "voa_store/test_faults.py": "bits and pages that a disk has changed or kept",
    "voa_store/test_state_machine.py": "random sequences of calls against a model of the store",
}
"""Tests that are named after a topic and not after a module, with the topic."""
TESTED_ELSEWHERE = {
    "backup_command": "tests/voa_service/test_backup.py and test_restore.py",
    "bootstrap": "builds everything: every test with the fixture `service` does",
    "ports": "protocols and types alone; tests/voa_store/test_conformance.py holds the store to them",
    "services": "a record of what `bootstrap` builds",
    "http/app": "puts the routes together: tests/contract",
    "http/calls": "tests/contract/test_bad_input.py",
    "http/openapi": "tests/contract/test_openapi.py",
    "http/problems": "tests/contract/test_bad_input.py",
    "http/routes": "thin, one call of a use case each: tests/contract",
    "meshes/worker": "a process of its own: tests/voa_service/meshes/test_reader.py",
    "zenoh/joining": "tests/voa_service/zenoh/test_claimed_robots.py and test_late_messages.py",
    "zenoh/samples": "a record",
    "zenoh/scans": "tests/voa_service/zenoh/test_entry.py, with a real router",
}
"""Modules and folders of `voa_service` without a test file of their own, and where they are tested."""


def modules_of(package: str) -> set[str]:
    """Modules and folders of a package as paths without suffix, such as "http/routes"; private names without "_"."""
    source = REPOSITORY / PACKAGES[package].folder
    inside = [path.relative_to(source) for path in files_of(source)]
    modules = {path.with_name(path.stem.removeprefix("_")).as_posix() for path in inside if path.stem != "__init__"}
    return modules | {path.parent.as_posix() for path in inside if path.parent != Path()}


def mirrored(package: str) -> dict[str, str]:
    """Test files of a package, each with the module or folder that its name stands for."""
    tests = REPOSITORY / "tests" / package
    files = [path.relative_to(tests) for path in sorted(tests.rglob("test_*.py"))]
    return {
        f"{package}/{path.as_posix()}": path.with_name(path.stem.removeprefix("test_")).as_posix() for path in files
    }


@pytest.mark.parametrize("package", PACKAGES)
def test_every_test_file_is_named_after_a_module_or_is_a_listed_topic(package: str) -> None:
    modules = modules_of(package)
    assert [file for file, module in mirrored(package).items() if module not in modules and file not in TOPICS] == []


def test_every_listed_topic_is_a_test_file_without_a_module() -> None:
    files = {file: module for package in PACKAGES for file, module in mirrored(package).items()}
    assert sorted(set(TOPICS) - set(files)) == []
    assert [file for file in TOPICS if files[file] in modules_of(file.partition("/")[0])] == []


def test_every_module_of_the_service_has_its_test_file_or_a_reason() -> None:
    modules = {module for module in modules_of("voa_service") if not module.rpartition("/")[2].startswith("_")}
    folders_ = {module for module in modules if (REPOSITORY / PACKAGES["voa_service"].folder / module).is_dir()}
    tested = set(mirrored("voa_service").values())
    excused = {module for module in modules if any(f"{module}/".startswith(f"{name}/") for name in TESTED_ELSEWHERE)}
    assert sorted(modules - folders_ - tested - excused) == []
    assert sorted(set(TESTED_ELSEWHERE) - modules) == [], "no reason is left for a module that is gone"
    assert sorted(set(TESTED_ELSEWHERE) & tested) == [], "a module with a test file needs no reason"


def test_every_package_is_typed() -> None:
    assert not [folder.name for folder in folders() if not (folder / "py.typed").is_file()]
