"""Scenarios as data: objects (mesh, poses, grasps, sensor configurations), a recorded experiment, lidar presets.

| folder             | holds                                                                     |
|--------------------|---------------------------------------------------------------------------|
| `lidars/`          | one preset per file: beams, range, noise, what a zero means, and why      |
| `mug/`             | `mug.obj`, the program that makes it, `scenario.json`, `physics.json`     |
| `mallet/`, `block/`| the same                                                                  |
| `experiments/mug/` | synthetic scans of the mug in the format of a recorded experiment         |

Nothing is read before it is asked for, and nothing but the standard library is needed.
"""

import json
from importlib.resources import files
from pathlib import Path
from typing import Any


def path(name: str) -> Path:
    """The folder or file `name` of this package, such as "mug" or "experiments/mug".

    Raises:
        FileNotFoundError: there is no such thing; lists what there is.
    """
    root = Path(str(files(__name__)))
    found = (root / name).resolve()
    if not found.exists() or not found.is_relative_to(root.resolve()):
        listed = sorted(f"{entry.parent.relative_to(root).as_posix()}" for entry in root.rglob("*.json"))
        raise FileNotFoundError(f"no asset {name!r}; there are: {', '.join(dict.fromkeys(listed))}")
    return found


def lidar_presets() -> dict[str, dict[str, Any]]:
    """Every lidar preset by its name, sorted.

    Each has `name, title, beams, angle_min, angle_increment` (rad, counter-clockwise), `range_min, range_max` (m),
    `zero` ("missing" or "no_return"), `noise_m, noise_ratio, dropout`, and `source`: where the figures come from.
    """
    presets = [json.loads(file.read_text(encoding="utf-8")) for file in sorted(path("lidars").glob("*.json"))]
    return {preset["name"]: preset for preset in presets}
