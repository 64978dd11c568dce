"""Files of a scenario in its folder, written so that a person can read and change them."""

import json
import os
import shutil
from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Any

from pydantic import BaseModel

from voa_core.checks import Floats
from voa_fleet.world.objects import Physics
from voa_msgs.scenarios import Grasp, ScenarioRequest
from voa_setup.errors import UnusableFolder

SCENARIO, PHYSICS = "scenario.json", "physics.json"
PARTIAL = "scores.partial"
"""File that marks a scenario as unfinished; it has the finished cells of the table of scores, from which a later run
resumes."""
EARLIER = "scenario.before.json"
"""Copy of a finished scenario that a new one replaced, where the two differ: a person may have changed it by hand."""
_MARGIN_M = 0.02
_MARGIN_SIGMAS = 3.0
_STEP_M = 0.01
_SHORT = 3  # values of a list that is no row of a table, such as a direction


def check_folder(folder: Path, mesh: Path, *, force: bool) -> None:
    """Check that the files of a scenario can be written into a folder, and write nothing yet.

    Args:
        folder: for the files; it may exist.
        mesh: the file that was read; a file of its name that ends with .obj is to be written.
        force: True to write over a scenario that is there.

    Raises:
        UnusableFolder: the folder has a finished scenario, is no folder, cannot be written into, or the mesh itself
            would be written over.
    """
    if (folder / f"{mesh.stem}.obj").resolve() == mesh.resolve():
        raise UnusableFolder(f"{mesh} would be written over: choose another folder by -o")
    nearest = next(parent for parent in (folder.absolute(), *folder.absolute().parents) if os.path.lexists(parent))
    if not nearest.is_dir():
        raise UnusableFolder(f"{nearest} is a file, where a folder is expected: choose another folder by -o")
    if not os.access(nearest, os.W_OK | os.X_OK):
        raise UnusableFolder(f"{nearest} cannot be written into: choose another folder by -o")
    if (folder / SCENARIO).exists() and not force and not (folder / PARTIAL).exists():
        raise UnusableFolder(f"{folder} has a scenario: choose another folder by -o, or add --force to write over it")


def begun_folder(folder: Path) -> None:
    """Make a folder, and mark its files as unfinished until `finish_folder`, so that a later run may write over them.

    A finished scenario that is there is copied first; `earlier_scenario` says what became of the copy.

    Raises:
        UnusableFolder: the folder or a file in it cannot be made.
    """
    try:
        folder.mkdir(parents=True, exist_ok=True)
        if (folder / SCENARIO).exists() and not (folder / PARTIAL).exists():
            shutil.copyfile(folder / SCENARIO, folder / EARLIER)
        (folder / PARTIAL).touch()
    except OSError as error:
        raise UnusableFolder(f"{folder} cannot be written into: {error.strerror}; choose another by -o") from error


def earlier_scenario(folder: Path) -> list[str]:
    """Keep the copy of an earlier scenario if it differs from the new one, and say so; else remove it."""
    earlier = folder / EARLIER
    if not earlier.exists():
        return []
    if earlier.read_bytes() == (folder / SCENARIO).read_bytes():
        earlier.unlink()
        return []
    return [f"The scenario that was in the folder differs from the new one: it is kept as {EARLIER}."]


def finish_folder(folder: Path) -> None:
    """Mark the files of a folder as finished."""
    (folder / PARTIAL).unlink(missing_ok=True)


def workspace_around(footprints: Iterable[Floats], xy_m: float) -> dict[str, list[float]]:
    """Return the workspace: a rectangle around the object at every pose, 2 cm and three standard deviations wider.

    Args:
        footprints: points (v, 2) of the object at each pose, metres.
        xy_m: standard deviation of the object's position.
    """
    margin = _MARGIN_M + _MARGIN_SIGMAS * xy_m
    low, high = [float("inf")] * 2, [-float("inf")] * 2
    for points in footprints:
        low = [min(a, b) for a, b in zip(low, points.min(axis=0).tolist(), strict=True)]
        high = [max(a, b) for a, b in zip(high, points.max(axis=0).tolist(), strict=True)]
    return {
        "min": [round((side - margin) // _STEP_M * _STEP_M, 3) for side in low],
        "max": [round(-((-side - margin) // _STEP_M) * _STEP_M, 3) for side in high],
    }


def grasps_of(names_and_data: Iterable[tuple[str, BaseModel]]) -> list[Grasp]:
    """Make the grasps of a scenario, each with its geometry as `data`."""
    return [Grasp(name=name, data=data.model_dump(mode="json")) for name, data in names_and_data]


def write_scenario(scenario: ScenarioRequest, folder: Path) -> Path:
    """Write `scenario.json`: a line for each pose, grasp, place and row of scores."""
    return _write(folder / SCENARIO, scenario.model_dump(mode="json", by_alias=True, exclude_unset=True))


def write_physics(physics: Physics, folder: Path) -> Path:
    """Write `physics.json`, a line for each solid and rest; grasps have their geometry in `scenario.json`."""
    return _write(folder / PHYSICS, physics.model_dump(mode="json", exclude_unset=True, exclude={"grasps"}))


def _write(file: Path, content: Mapping[str, Any]) -> Path:
    lines = [f" {json.dumps(key)}: {_block(value)}" for key, value in content.items()]
    file.write_text("{\n" + ",\n".join(lines) + "\n}\n", encoding="utf-8", newline="\n")
    return file


def _block(value: Any) -> str:
    """Write a value in one line; an object or list that holds objects or lists gets a line for each of them."""
    if isinstance(value, Mapping) and any(_is_nested(item) for item in value.values()):
        return _lines("{", [f"{json.dumps(key)}: {_block_of_rows(item)}" for key, item in value.items()], "}")
    if isinstance(value, list) and _is_nested(value):
        return _lines("[", [json.dumps(item, ensure_ascii=False) for item in value], "]")
    return json.dumps(value, ensure_ascii=False)


def _block_of_rows(value: Any) -> str:
    """Write a list of lists with a line for each, indented below its key; anything else in one line."""
    if isinstance(value, list) and value and isinstance(value[0], list) and len(value[0]) > _SHORT:
        return "[\n   " + ",\n   ".join(map(json.dumps, value)) + "\n  ]"
    return json.dumps(value, ensure_ascii=False)


def _is_nested(value: Any) -> bool:
    """True for an object, and for a list of objects or lists."""
    return isinstance(value, Mapping) or (
        isinstance(value, list) and bool(value) and isinstance(value[0], Mapping | list)
    )


def _lines(opening: str, items: list[str], closing: str) -> str:
    return opening + "\n  " + ",\n  ".join(items) + "\n " + closing
