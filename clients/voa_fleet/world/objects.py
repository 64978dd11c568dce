"""Objects of the fleet: a scenario with its mesh, and the physical properties that the service need not know.

| file            | content                                                                            |
|-----------------|------------------------------------------------------------------------------------|
| `scenario.json` | the body of `POST /v1/scenarios`; `object` is the mesh's file name                 |
| the mesh        | an OBJ file in metres, which the lidar sees                                        |
| `physics.json`  | `density_kg_m3`, `friction`, `gripper`, `solids`, `grasps`, `rests`: see `Physics` |
"""

from dataclasses import dataclass, replace
from pathlib import Path
from typing import Annotated, Literal, TypeVar

from annotated_types import Ge, Gt
from pydantic import BaseModel, ConfigDict, Field, ValidationError

from voa_assets import path as asset_path
from voa_client.message_files import read_file
from voa_fleet.errors import InvalidObject, UnknownName
from voa_fleet.world.meshes import Mesh, read_obj
from voa_msgs.scenarios import Pose, ScenarioRequest

M = TypeVar("M", bound=BaseModel)

OBJECTS = ("mug", "mallet", "block", "goblet", "coupling")
"""Names of the objects that are part of this project."""

Vector = tuple[float, float, float]
Length = Annotated[float, Gt(0.0)]
Touches = Literal["table", "gripper", "both"]
"""Partners with which a solid collides: fewer pairs are faster, and a tube of boxes need not rest on the table."""


class _Part(BaseModel):
    model_config = ConfigDict(frozen=True, extra="forbid", allow_inf_nan=False, use_attribute_docstrings=True)


class Box(_Part):
    """A box along the axes of the object's frame."""

    kind: Literal["box"]
    centre: Vector
    size: tuple[Length, Length, Length]
    touches: Touches = "both"


class Cylinder(_Part):
    """A cylinder from `start` to `end`."""

    kind: Literal["cylinder"]
    start: Vector
    end: Vector
    radius: Length
    touches: Touches = "both"


class Capsule(_Part):
    """A cylinder from `start` to `end` with a half ball at each end."""

    kind: Literal["capsule"]
    start: Vector
    end: Vector
    radius: Length
    touches: Touches = "both"


class Tube(_Part):
    """A wall of `pieces` boxes around the line from `start` to `end`."""

    kind: Literal["tube"]
    start: Vector
    end: Vector
    radius: Length
    """Radius of the outside."""
    wall: Length
    pieces: Annotated[int, Ge(3)]
    touches: Touches = "both"


Solid = Annotated[Box | Cylinder | Capsule | Tube, Field(discriminator="kind")]


class GripperSetting(_Part):
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


class GraspGeometry(_Part):
    """Pose of the gripper for a grasp in the world frame; it is fixed, because the object's pose is not known."""

    tip: Vector
    """Point between the fingertips when they close."""
    approach: Vector
    """Direction in which the fingers point and approach."""
    closing: Vector
    """Direction along which the fingers close."""


class Rest(_Part):
    """A way of the object to rest on the table."""

    poses: list[str]
    """Poses of the scenario that rest this way; empty where the scenario leaves it out."""
    ups: Annotated[list[Vector], Field(min_length=1)]
    """Directions in the object's frame that point up at rest, of any length; several for a symmetric shape."""


class Physics(_Part):
    """Physical properties of an object that the simulation needs beside the scenario."""

    density_kg_m3: Length
    friction: Length
    gripper: GripperSetting
    solids: Annotated[list[Solid], Field(min_length=1)]
    """Solids that collide, in the object's frame; the mesh itself is only seen by the lidar."""
    grasps: dict[str, GraspGeometry]
    """Geometry of each grasp, by its name in the scenario."""
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
    """

    name: str
    folder: Path
    scenario: ScenarioRequest
    physics: Physics
    mesh: Mesh

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
        if name not in self.physics.grasps:
            raise UnknownName("grasp", name, self.grasps)
        return self.physics.grasps[name]

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
    target = FleetObject(scenario.name, folder, scenario, physics, read_obj(folder / scenario.object))
    _check(target)
    return target


def _read(file: Path, model: type[M]) -> M:
    return read_file(model, file, InvalidObject)


def _check(target: FleetObject) -> None:
    where = target.folder / "physics.json"
    if set(target.physics.grasps) != set(target.grasps):
        raise InvalidObject(f"{where}: expected grasps {target.grasps}, got {sorted(target.physics.grasps)}")
    resting = [pose for rest in target.physics.rests.values() for pose in rest.poses]
    if sorted(resting) != sorted(target.poses):
        absent = sorted(set(target.poses) - set(resting))
        repeated = sorted({pose for pose in resting if resting.count(pose) > 1})
        unknown = sorted(set(resting) - set(target.poses))
        raise InvalidObject(
            f"{where}: expected each pose under exactly one of `rests`: missing {absent}, repeated {repeated}, "
            f"unknown {unknown}"
        )
    if any(pose.position is None or pose.quaternion_wxyz is None for pose in target.scenario.poses):
        raise InvalidObject(f"{target.folder / 'scenario.json'}: expected position and quaternion_wxyz of every pose")
    if target.scenario.lidar.height_m is None:
        raise InvalidObject(f"{target.folder / 'scenario.json'}: expected lidar.height_m, got none")
