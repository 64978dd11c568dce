"""Objects of the fleet: a scenario with its mesh, and the physical properties that the service need not know.

| file            | content                                                                                     |
|-----------------|---------------------------------------------------------------------------------------------|
| `scenario.json` | the body of `POST /v1/scenarios`; `object` is the mesh's file name, and the `data` of each  |
|                 | grasp its geometry (`voa_msgs.grasp_geometry`)                                              |
| the mesh        | an OBJ file in metres, which the lidar sees                                                 |
| `physics.json`  | `density_kg_m3`, `friction`, `gripper`, `solids`, `rests`, and optionally `grasps`: see     |
|                 | `Physics`                                                                                   |
"""

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Annotated, TypeVar

import numpy as np
from annotated_types import Gt
from pydantic import BaseModel, Field, ValidationError

from voa_assets import path as asset_path
from voa_client.message_files import read_file
from voa_fleet.errors import InvalidObject, UnknownName
from voa_fleet.world.frames import tool_rotation
from voa_fleet.world.meshes import LEAST_M3, Mesh, read_groups, read_obj, volume_of
from voa_fleet.world.shapes import Hulls, Length, Part, Solid, Vector
from voa_msgs.grasp_geometry import GraspGeometry, grasp_geometry
from voa_msgs.scenarios import Pose, ScenarioRequest

M = TypeVar("M", bound=BaseModel)

OBJECTS = ("mug", "mallet", "block", "goblet", "coupling")
"""Names of the objects that are part of this project."""


class GripperSetting(Part):
    """Setting of the gripper for an object."""

    opening_m: Annotated[float, Gt(0.0), Field(le=0.2)]
    """Distance between the open fingers: 0.018 in the paper, 0.085 for a Robotiq 2F-85."""
    force_n: Length
    """Force of each finger."""
    finger_length_m: Length = 0.055
    """Length of a finger from the palm to its tip."""
    finger_thickness_m: Length = 0.008
    """Thickness of a finger along the direction in which it closes."""
    finger_width_m: Length = 0.020
    """Width of a finger across the directions in which it closes and in which it points."""
    palm_width_m: Length = 0.028
    """Width of the hand behind the fingers, in the direction of `finger_width_m`: what must fit between it and the
    table where the hand comes from the side."""


class TipGeometry(Part):
    """Geometry of a grasp as `physics.json` may state it; a grasp's `data` in the scenario is the usual place."""

    tip: Vector
    """Point between the fingertips when they close, in the world frame."""
    approach: Vector
    """Direction in which the fingers point and approach."""
    closing: Vector
    """Direction along which the fingers close; the part of it along `approach` does not matter."""

    def geometry(self) -> GraspGeometry:
        """Return the geometry as a grasp's `data` states it; raises ValidationError for parallel directions."""
        closing = tool_rotation(self.approach, self.closing)[:, 0].tolist() if self._oblique() else self.closing
        return GraspGeometry(tool_centre_point=self.tip, approach=self.approach, closing=closing)

    def _oblique(self) -> bool:
        """True if the directions are neither perpendicular nor parallel."""
        along = sum(a * c for a, c in zip(self.approach, self.closing, strict=True))
        across = float(np.linalg.norm(np.cross(self.approach, self.closing)))
        return along != 0.0 and across > 0.0


class Rest(Part):
    """A way of the object to rest on the table."""

    poses: list[str]
    """Poses of the scenario that rest this way; empty where the scenario leaves it out."""
    ups: Annotated[list[Vector], Field(min_length=1)]
    """Directions in the object's frame that point up at rest, of any length; several for a symmetric shape."""


class Physics(Part):
    """Physical properties of an object that the simulation needs beside the scenario."""

    density_kg_m3: Length
    friction: Length
    gripper: GripperSetting
    solids: Annotated[list[Solid], Field(min_length=1)]
    """Solids that collide, in the object's frame; the mesh itself is only seen by the lidar."""
    grasps: Annotated[dict[str, TipGeometry], Field(default_factory=dict)]
    """Geometry of grasps by their names, in place of that in their `data`; usually there is none here."""
    rests: dict[str, Rest]
    """Ways to rest, by name."""


@dataclass(frozen=True, eq=False)
class FleetObject:
    """An object that the fleet can look at and grasp.

    Attributes:
        name: of the scenario.
        folder: with the object's files.
        scenario: as in the file; its `object` is the mesh's file name.
        physics: the physical properties.
        mesh: in metres, in the object's frame.
        geometries: of the grasps, by name.
        hulls: convex pieces of each file that `physics.solids` names, in metres, in the object's frame.
    """

    name: str
    folder: Path
    scenario: ScenarioRequest
    physics: Physics
    mesh: Mesh
    geometries: Mapping[str, GraspGeometry]
    hulls: Mapping[str, tuple[Mesh, ...]] = field(default_factory=dict)

    @property
    def poses(self) -> list[str]:
        """Names of the poses, in the scenario's order."""
        return [pose.name for pose in self.scenario.poses]

    @property
    def grasps(self) -> list[str]:
        """Names of the grasps, in the scenario's order."""
        return [grasp.name for grasp in self.scenario.grasps]

    def pose(self, name: str) -> Pose:
        """Return the pose of that name; raises UnknownName."""
        for pose in self.scenario.poses:
            if pose.name == name:
                return pose
        raise UnknownName("pose", name, self.poses)

    def grasp(self, name: str) -> GraspGeometry:
        """Return the geometry of the grasp of that name; raises UnknownName."""
        if name not in self.geometries:
            raise UnknownName("grasp", name, self.grasps)
        return self.geometries[name]

    def with_opening(self, opening_m: float) -> "FleetObject":
        """Return a copy of the object for a gripper with another opening, metres.

        Raises:
            InvalidObject: the opening is not between 0 and 0.2 m.
        """
        changed = self.physics.gripper.model_dump() | {"opening_m": opening_m}
        try:
            setting = GripperSetting.model_validate(changed)
        except ValidationError as error:
            raise InvalidObject(f"opening_m: {error.errors()[0]['msg']}, got {opening_m}") from error
        return replace(self, physics=self.physics.model_copy(update={"gripper": setting}))

    @property
    def lidar_height_m(self) -> float:
        """Height of the scan plane over the table."""
        return self.scenario.lidar.height_m or 0.0


def named_object(name: str) -> FleetObject:
    """Read one of the project's objects by its name, or the object of a folder by its path.

    Raises:
        UnknownName: there is no such object and no such folder.
        InvalidObject: the folder does not describe an object.
    """
    if name in OBJECTS:
        return read_object(asset_path(name))
    if Path(name).is_dir():
        return read_object(Path(name))
    raise UnknownName("object", name, [*OBJECTS, "a folder"])


def read_object(folder: Path) -> FleetObject:
    """Read an object's folder.

    Raises:
        InvalidObject: a file is missing or invalid, or the files contradict each other; the message says where.
    """
    scenario = _read(folder / "scenario.json", ScenarioRequest)
    physics = _read(folder / "physics.json", Physics)
    if scenario.object is None:
        raise InvalidObject(f"{folder / 'scenario.json'}: expected the mesh's file name as `object`, got none")
    _check(folder, scenario, physics)
    mesh = read_obj(_inside(folder, scenario.object))
    hulls = {solid.file: _pieces(folder, solid.file) for solid in physics.solids if isinstance(solid, Hulls)}
    return FleetObject(scenario.name, folder, scenario, physics, mesh, _geometries(folder, scenario, physics), hulls)


def _read(file: Path, model: type[M]) -> M:
    return read_file(model, file, InvalidObject)


def _inside(folder: Path, name: str) -> Path:
    """Path of a file in a folder; raises InvalidObject for a name that leads out of it."""
    file = folder / name
    if not file.resolve().is_relative_to(folder.resolve()):
        raise InvalidObject(f"{folder}: expected the name of a file in this folder, got {name!r}")
    return file


def _pieces(folder: Path, name: str) -> tuple[Mesh, ...]:
    """Read convex pieces; raises InvalidObject for one that is flat, because a simulation cannot collide it."""
    file = _inside(folder, name)
    pieces = tuple(read_groups(file))
    for index, piece in enumerate(pieces):
        if volume_of(piece) <= LEAST_M3:
            raise InvalidObject(f"{file}: expected pieces that have volume, got a flat one: number {index} from 0")
    return pieces


def _geometries(folder: Path, scenario: ScenarioRequest, physics: Physics) -> dict[str, GraspGeometry]:
    """Geometry of every grasp: from physics.json where it is there, else from the grasp's `data`."""
    geometries: dict[str, GraspGeometry] = {}
    for grasp in scenario.grasps:
        own, file = physics.grasps.get(grasp.name), folder / ("physics.json" if physics.grasps else "scenario.json")
        try:
            geometry = grasp_geometry(grasp.data) if own is None else own.geometry()
        except ValidationError as error:
            mistake = error.errors()[0]
            where = ".".join(str(part) for part in mistake["loc"])
            raise InvalidObject(f"{file}: geometry of grasp {grasp.name!r}: {where}: {mistake['msg']}") from error
        if geometry is None:
            raise InvalidObject(
                f"{file}: grasp {grasp.name!r} has no geometry: expected tool_centre_point, approach and closing in "
                f"its `data` (voa_msgs.grasp_geometry), or the grasp under `grasps` of physics.json"
            )
        geometries[grasp.name] = geometry
    return geometries


def _check(folder: Path, scenario: ScenarioRequest, physics: Physics) -> None:
    where = folder / "physics.json"
    grasps, poses = [grasp.name for grasp in scenario.grasps], [pose.name for pose in scenario.poses]
    if not set(physics.grasps) <= set(grasps):
        raise InvalidObject(f"{where}: expected grasps of the scenario, {grasps}, got {sorted(physics.grasps)}")
    resting = [pose for rest in physics.rests.values() for pose in rest.poses]
    if sorted(resting) != sorted(poses):
        absent = sorted(set(poses) - set(resting))
        repeated = sorted({pose for pose in resting if resting.count(pose) > 1})
        unknown = sorted(set(resting) - set(poses))
        raise InvalidObject(
            f"{where}: expected each pose under exactly one of `rests`: missing {absent}, repeated {repeated}, "
            f"unknown {unknown}"
        )
    if any(pose.position is None or pose.quaternion_wxyz is None for pose in scenario.poses):
        raise InvalidObject(f"{folder / 'scenario.json'}: expected position and quaternion_wxyz of every pose")
    if scenario.lidar.height_m is None:
        raise InvalidObject(f"{folder / 'scenario.json'}: expected lidar.height_m, got none")
