"""Data that the project ships: scenarios with their meshes, a recorded experiment, and lidar presets.

| folder             | content                                                                   |
|--------------------|---------------------------------------------------------------------------|
| `lidars/`          | one preset per file: beams, range, noise, meaning of a zero, and sources  |
| `mug/`             | `mug.obj`, the program that makes it, `scenario.json`, `physics.json`     |
| `mallet/`, `block/`| mesh, program, scenario and physics of two more objects                   |
| `goblet/`          | an object for which the look for most information is not the best look    |
| `coupling/`        | an object for which two looks are needed                                  |
| `experiments/mug/` | synthetic scans of the mug in the format of a recorded experiment         |

Files are read on request, with the standard library alone. The programs that make meshes share `make_obj`.
"""

import json
from importlib.resources import files
from pathlib import Path
from typing import Any


def path(name: str) -> Path:
    """Path of a folder or file of this package, such as "mug" or "experiments/mug".

    Raises:
        FileNotFoundError: there is no such folder or file; the message lists the folders.
    """
    root = Path(str(files(__name__)))
    asset = (root / name).resolve()
    if not asset.exists() or not asset.is_relative_to(root.resolve()):
        listed = sorted(f"{entry.parent.relative_to(root).as_posix()}" for entry in root.rglob("*.json"))
        raise FileNotFoundError(f"no asset {name!r}; there are: {', '.join(dict.fromkeys(listed))}")
    return asset


def lidar_presets() -> dict[str, dict[str, Any]]:
    """Lidar presets by name, sorted.

    A preset has `name, title, beams, angle_min, angle_increment` (rad, counter-clockwise), `range_min, range_max` (m),
    `zero` ("missing" or "no_return"), `noise_m, noise_ratio, dropout`, and `source`, the origin of the figures.
    """
    presets = [json.loads(file.read_text(encoding="utf-8")) for file in sorted(path("lidars").glob("*.json"))]
    return {preset["name"]: preset for preset in presets}
