"""File of the finished cells of a table of scores under way: JSON lines, the first of which says what they depend on.

A simulation that is ended early continues from it. A file that depends on something else, or is damaged, is
replaced by an empty one: cells are made in minutes, and a wrong one would stay in the scenario.
"""

import json
from collections.abc import Iterable
from dataclasses import dataclass
from hashlib import sha256
from pathlib import Path

import mujoco
import numpy as np
from pydantic import BaseModel, ConfigDict, ValidationError

from voa_fleet.world.objects import FleetObject

FORMAT = 1
"""Version of the attempts: raised when the simulation changes, so that no table mixes both."""


class _Heading(BaseModel):
    model_config = ConfigDict(extra="forbid", strict=True)

    depends_on: str


class FinishedCell(BaseModel):
    """A finished cell of a table of scores.

    Attributes:
        pose, grasp: their names.
        successes: number of attempts that lifted the object.
    """

    model_config = ConfigDict(extra="forbid", strict=True, frozen=True)

    pose: str
    grasp: str
    successes: int


@dataclass(frozen=True)
class PartialTable:
    """File of finished cells.

    Attributes:
        file: to read and extend.
        depends_on: digest of what the cells depend on; cells of a file with another digest are not used.
    """

    file: Path
    depends_on: str

    def read(self) -> list[FinishedCell]:
        """Read the finished cells; begin an empty file where it is absent, damaged or depends on something else.

        Raises:
            OSError: the file cannot be read or written.
        """
        cells = self._finished()
        lines = [_Heading(depends_on=self.depends_on).model_dump_json(), *(cell.model_dump_json() for cell in cells)]
        self.file.write_text("".join(f"{line}\n" for line in lines), encoding="utf-8")
        return cells

    def add(self, cell: FinishedCell) -> None:
        """Append a finished cell."""
        with self.file.open("a", encoding="utf-8") as lines:
            lines.write(f"{cell.model_dump_json()}\n")

    def _finished(self) -> list[FinishedCell]:
        if not self.file.exists():
            return []
        heading, *lines = self.file.read_text(encoding="utf-8", errors="replace").splitlines() or [""]
        try:
            if _Heading.model_validate_json(heading).depends_on != self.depends_on:
                return []
        except ValidationError:
            return []
        return list(_valid(lines))


def _valid(lines: Iterable[str]) -> Iterable[FinishedCell]:
    """Yield the cells up to the first damaged line, which an interrupted write leaves."""
    for line in lines:
        try:
            yield FinishedCell.model_validate_json(line)
        except ValidationError:
            return


def digest_of(target: FleetObject, attempts: int, xy_m: float, yaw_rad: float, seed: int) -> str:
    """Return a digest of everything on which the cells of an object depend, MuJoCo's version included.

    Args:
        target: the object, whose poses and grasps may be listed in any order.
        attempts: per cell.
        xy_m, yaw_rad: standard deviations of the pose noise, metres and radians.
        seed: of the noise.
    """
    settings = {
        "format": FORMAT,
        "mujoco": mujoco.__version__,
        "attempts": attempts,
        "noise": [xy_m, yaw_rad],
        "seed": seed,
        "physics": target.physics.model_dump(mode="json", exclude={"rests", "grasps"}),
        "poses": {pose.name: [pose.position, pose.quaternion_wxyz] for pose in target.scenario.poses},
        "grasps": {name: geometry.model_dump(mode="json") for name, geometry in target.geometries.items()},
        "meshes": [
            sha256(np.ascontiguousarray(array).tobytes()).hexdigest()
            for mesh in (target.mesh, *(piece for pieces in target.hulls.values() for piece in pieces))
            for array in (mesh.vertices, mesh.faces)
        ],
    }
    return sha256(json.dumps(settings, sort_keys=True).encode()).hexdigest()
