"""The object of a scenario file, cut by the scan plane at one of its poses, and the scans that it would give."""

from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from voa_assets import lidar_presets
from voa_client import VoaClientError
from voa_client.message_files import read_file
from voa_client.scenario_files import InvalidScenarioFile, ScenarioFile
from voa_core.cutting import Contours, cut_poses
from voa_core.errors import VoaError
from voa_core.lidars import BeamGrid, SensorConfiguration
from voa_core.objects import Object
from voa_core.poses import PoseSet
from voa_core.rasterising import rasterise
from voa_setup.calibration.planar import Floats, inverse
from voa_setup.errors import UnusableMesh
from voa_setup.mesh import read_triangles


class InvalidCalibration(VoaClientError):
    """A calibration lacks something; the message says what, and what was expected."""


@dataclass(frozen=True, eq=False)
class KnownObject:
    """Object at a known pose, cut by the plane of the lidar.

    Attributes:
        contours: the cut, of one pose.
        centre: (2,) middle of the cut in the world, metres.
        radius_m: largest distance of the cut from its middle, metres.
    """

    contours: Contours
    centre: Floats
    radius_m: float

    def ranges(self, lidars: Floats, grid: BeamGrid, range_max: float) -> Floats:
        """Predict the scans from many poses of the lidar.

        Args:
            lidars: (k, 3) x, y, yaw in the world.
            grid: beams of the scans.
            range_max: metres.

        Returns:
            (k, beams) metres, inf where a beam does not meet the object.
        """
        cos, sin, x, y = self.contours.placement[0]
        away = inverse(lidars)
        turn_cos, turn_sin = np.cos(away[:, 2]), np.sin(away[:, 2])
        placement = np.column_stack(
            [
                turn_cos * cos - turn_sin * sin,
                turn_sin * cos + turn_cos * sin,
                away[:, 0] + turn_cos * x - turn_sin * y,
                away[:, 1] + turn_sin * x + turn_cos * y,
            ]
        )
        seen = replace(self.contours, cut_of_pose=np.zeros(len(lidars), dtype=np.int64), placement=placement)
        return rasterise(seen, SensorConfiguration("lidar", 0.0, 0.0, 0.0), grid, range_max)


@dataclass(frozen=True, eq=False)
class Scene:
    """Object and lidar of a scenario file, as far as a calibration needs them.

    Attributes:
        mesh: of the object.
        poses: all poses of the scenario.
        grid: beams of the lidar.
        range_max: of the lidar, metres.
        height_m: of the scan plane over the table, metres; None: the scenario states none.
        noise_m: standard deviation of a short range, metres.
    """

    mesh: Object
    poses: PoseSet
    grid: BeamGrid
    range_max: float
    height_m: float | None
    noise_m: float

    def at(self, pose: str, height_m: float | None) -> KnownObject:
        """Cut the object at a pose.

        Args:
            pose: name of the pose.
            height_m: of the scan plane, from the robot's mapping, metres; None: the scenario's.

        Raises:
            InvalidCalibration: there is no such pose, no height, or the plane misses the object.
        """
        if pose not in self.poses.names:
            raise InvalidCalibration(f"the scenario has no pose {pose!r}; it has {', '.join(self.poses.names)}")
        height = self.height_m if height_m is None else height_m
        if height is None:
            raise InvalidCalibration("expected lidar.height_m in the mapping of the robot or in the scenario")
        own = self.poses.subset(np.array([self.poses.names.index(pose)]))
        contours = cut_poses(self.mesh, own, height)
        if not len(contours.segments):
            raise InvalidCalibration(f"the scan plane at {height:g} m misses the object at {pose!r}")
        cos, sin, x, y = contours.placement[0]
        points = contours.points @ np.array([[cos, sin], [-sin, cos]]) + np.array([x, y])
        centre = 0.5 * (points.min(axis=0) + points.max(axis=0))
        return KnownObject(contours, centre, float(np.linalg.norm(points - centre, axis=1).max()))


def read_scene(path: Path) -> Scene:
    """Read the object, its poses and the lidar of a scenario file.

    Raises:
        InvalidScenarioFile: it is no scenario file.
        InvalidCalibration: it names no mesh file, its poses have no geometry, or its lidar is incomplete.
    """
    file = read_file(ScenarioFile, path, InvalidScenarioFile)
    mesh = None if file.object is None else path.parent / file.object
    if mesh is None or not mesh.is_file():
        raise InvalidCalibration(f"{path}: object: expected the name of a mesh file beside the scenario file")
    places = [pose.position for pose in file.poses if pose.position is not None]
    turns = [pose.quaternion_wxyz for pose in file.poses if pose.quaternion_wxyz is not None]
    if not len(places) == len(turns) == len(file.poses):
        raise InvalidCalibration(f"{path}: poses: expected position and quaternion_wxyz of every pose")
    lidar = dict(lidar_presets().get(file.lidar.preset or "", {}))
    lidar |= file.lidar.model_dump(exclude_none=True)
    try:
        grid = BeamGrid(lidar["beams"], lidar["angle_min"], lidar["angle_increment"])
        range_max, noise_m = float(lidar["range_max"]), float(lidar["noise_m"])
        poses = PoseSet.from_arrays([pose.name for pose in file.poses], places, turns)
        object_ = Object.from_arrays(*read_triangles(mesh, file.up), 1.0 if file.scale is None else file.scale)
    except KeyError as error:
        raise InvalidCalibration(f"{path}: lidar: expected a preset that exists, or {error}") from error
    except (VoaError, UnusableMesh, ValueError, OSError) as error:
        raise InvalidCalibration(f"{path}: {error}") from error
    return Scene(object_, poses, grid, range_max, file.lidar.height_m, noise_m)
