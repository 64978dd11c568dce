"""Objects of the fleet: a scenario with its mesh, and the physics that the service need not know.

| file            | content                                                                            |
|-----------------|------------------------------------------------------------------------------------|
| `scenario.json` | the body of `POST /v1/scenarios`; `object` is the mesh's file name                 |
| the mesh        | an OBJ file in metres: what the lidar sees                                         |
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

OBJECTS = ("mug", "mallet", "block")
"""The objects that this project brings."""

Vector = tuple[float, float, float]
Length = Annotated[float, Gt(0.0)]
Touches = Literal["table", "gripper", "both"]
"""What collides with a solid: fewer pairs are faster, and a tube of boxes need not rest on the table."""


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
    """Of the outside."""
    wall: Length
    pieces: Annotated[int, Ge(3)]
    touches: Touches = "both"


Solid = Annotated[Box | Cylinder | Capsule | Tube, Field(discriminator="kind")]


class GripperSetting(_Part):
    """How the gripper is set for an object."""

    opening_m: Annotated[float, Gt(0.0), Field(le=0.2)]
    """Between the open fingers: 0.018 as in the paper, 0.085 as a Robotiq 2F-85."""
    force_n: Length
    """With which each finger squeezes."""


class GraspGeometry(_Part):
    """Where the gripper goes, in the world frame: its place does not follow the object, whose pose is not known."""

    tip: Vector
    """Middle between the fingertips when they close."""
    approach: Vector
    """Direction in which the fingers point and come."""
    closing: Vector
    """Direction along which the fingers close."""


class Rest(_Part):
    """One way to rest on the table."""

    poses: list[str]
    """The scenario's poses that rest so; none where the scenario leaves it out."""
    ups: Annotated[list[Vector], Field(min_length=1)]
    """Directions in the object's frame that then point up, of any length: several where its shape is symmetric."""


class Physics(_Part):
    """What the simulation needs beside the scenario."""

    density_kg_m3: Length
    friction: Length
    gripper: GripperSetting
    solids: Annotated[list[Solid], Field(min_length=1)]
    """What collides, in the object's frame; the mesh itself only meets the lidar's rays."""
    grasps: dict[str, GraspGeometry]
    """By the grasp's name in the scenario."""
    rests: dict[str, Rest]
    """The ways to rest, by name."""


@dataclass(frozen=True, eq=False)
class FleetObject:
    """An object that the fleet can look at and grasp.

    Attributes:
        name: the scenario's.
        folder: where its files are.
        scenario: as in the file: `object` is the mesh's file name.
        physics: the rest.
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
        """The pose of a name; raises UnknownName."""
        for pose in self.scenario.poses:
            if pose.name == name:
                return pose
        raise UnknownName("pose", name, self.poses)

    def grasp(self, name: str) -> GraspGeometry:
        """The geometry of a grasp; raises UnknownName."""
        if name not in self.physics.grasps:
            raise UnknownName("grasp", name, self.grasps)
        return self.physics.grasps[name]

    def with_opening(self, opening_m: float) -> "FleetObject":
        """The same object for a gripper that opens differently.

        Raises:
            InvalidObject: no gripper opens like that.
        """
        told = self.physics.gripper.model_dump() | {"opening_m": opening_m}
        try:
            setting = GripperSetting.model_validate(told)
        except ValidationError as error:
            raise InvalidObject(f"opening_m: {error.errors()[0]['msg']}, got {opening_m}") from error
        return replace(self, physics=self.physics.model_copy(update={"gripper": setting}))

    @property
    def lidar_height_m(self) -> float:
        """Height of the scan plane over the table."""
        return self.scenario.lidar.height_m or 0.0


def named_object(name: str) -> FleetObject:
    """One of the project's own objects, or the object of a folder.

    Raises:
        UnknownName: it is neither.
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
        InvalidObject: a file is missing or wrong, or the files do not go together; says how.
    """
    scenario = _read(folder / "scenario.json", ScenarioRequest)
    physics = _read(folder / "physics.json", Physics)
    if scenario.object is None:
        raise InvalidObject(f"{folder / 'scenario.json'}: expected the mesh's file name as `object`, got none")
    found = FleetObject(scenario.name, folder, scenario, physics, read_obj(folder / scenario.object))
    _check(found)
    return found


def _read(file: Path, model: type[M]) -> M:
    return read_file(model, file, InvalidObject)


def _check(found: FleetObject) -> None:
    where = found.folder / "physics.json"
    if set(found.physics.grasps) != set(found.grasps):
        raise InvalidObject(f"{where}: expected grasps {found.grasps}, got {sorted(found.physics.grasps)}")
    resting = [pose for rest in found.physics.rests.values() for pose in rest.poses]
    if sorted(resting) != sorted(found.poses):
        raise InvalidObject(f"{where}: expected every pose {found.poses} to rest in one way, got {resting}")
    if any(pose.position is None or pose.quaternion_wxyz is None for pose in found.scenario.poses):
        raise InvalidObject(f"{found.folder / 'scenario.json'}: expected position and quaternion_wxyz of every pose")
    if found.scenario.lidar.height_m is None:
        raise InvalidObject(f"{found.folder / 'scenario.json'}: expected lidar.height_m, got none")
