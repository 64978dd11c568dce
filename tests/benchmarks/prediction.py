"""Proof that cutting a mesh once and rasterising its contour beats casting rays at it, with the same answer.

3 200 scans (100 poses, 32 sensors, 360 beams) of a cup of about 1k, 10k and 100k faces; at poses that each have
a tilt of their own ("general": every pose is cut), and at six tilts turned and moved ("planar": six cuts). Ours
includes the cuts, and keeps of each scan the columns on which some pose returns. Trees and edge tables, made once
per mesh, are taken out on both sides. Peers:

* the embree kernel: `embreex` computing distances alone, every ray given to it ready-made, in float32;
* at general poses also the same kernel, given only the beams that meet a ball around the mesh, which few of them do;
* the API: trimesh with embreex, from poses and sensors to float64 hit points, ray building included.

In the same run every range is compared with the API's.
"""

from functools import partial

import numpy as np
from embreex import rtcore_scene
from embreex.mesh_construction import TriangleMesh
from numpy.typing import NDArray
from trimesh import Trimesh
from trimesh.ray.ray_pyembree import RayMeshIntersector

from tests.benchmarks import scene
from tests.benchmarks.measure import Result, faster, interleaved, require
from voa_core.checks import Floats
from voa_core.lidars import SensorConfiguration
from voa_core.objects import Object
from voa_core.poses import PoseSet
from voa_core.prediction import Prediction, predictor_of_mesh

_POSES, _SENSORS = 100, 32
_TOLERANCE_M = 1e-8
_SILHOUETTES = 1e-5  # share of beams that may pass an edge on the other side in embree's float32


def run() -> list[Result]:
    """Compare three sizes of meshes and two kinds of pose sets with two peers."""
    sensors = scene.sensors(_SENSORS)
    results = []
    for size in scene.SIZES:
        object_ = scene.cup(size)
        _ = object_.edges
        mesh = Trimesh(object_.vertices, object_.faces, process=False)
        api = RayMeshIntersector(mesh)
        kernel = rtcore_scene.EmbreeScene()
        TriangleMesh(kernel, object_.vertices[object_.faces].astype(np.float32))
        for kind in ("general", "planar"):
            poses = scene.poses(object_, _POSES, planar=kind == "planar")
            rays = [tuple(part.astype(np.float32) for part in _rays(poses, p, sensors)) for p in range(_POSES)]
            windows = _windows(object_, poses, sensors)
            seen = [tuple(part[window] for part in each) for each, window in zip(rays, windows, strict=True)]
            truth = _by_api(api, poses, sensors)
            _compare(_ours(object_, poses, sensors), truth)
            require(bool(np.isfinite(truth[~windows.reshape(truth.shape)]).sum() == 0), "a beam beside the ball hits")
            ours, bare, windowed, whole = interleaved(
                [
                    partial(_ours, object_, poses, sensors),
                    partial(_by_kernel, kernel, rays),
                    partial(_by_kernel, kernel, seen),
                    partial(_by_api, api, poses, sensors),
                ]
            )
            what = f"prediction, {size} faces, {kind} poses"
            results += [faster(f"{what} / embree kernel", ours, bare), faster(f"{what} / trimesh+embreex", ours, whole)]
            if kind == "general":
                results.append(faster(f"{what} / embree kernel, windowed beams", ours, windowed))
    return results


def _ours(object_: Object, poses: PoseSet, sensors: list[SensorConfiguration]) -> list[Prediction]:
    predictor = predictor_of_mesh(object_, poses, scene.LIDAR)
    return [predictor.predict(sensor) for sensor in sensors]


def _rays(poses: PoseSet, pose: int, sensors: list[SensorConfiguration]) -> tuple[Floats, Floats]:
    """Origins and directions (k * r, 3) of all beams, in the object's frame at one pose."""
    assert poses.rotations is not None
    assert poses.positions is not None
    beams = scene.LIDAR.grid.beams
    headings = np.concatenate([sensor.yaw_rad + scene.LIDAR.grid.angles for sensor in sensors])
    directions = np.column_stack([np.cos(headings), np.sin(headings), np.zeros(len(headings))])
    stands = np.array([[sensor.x, sensor.y, scene.LIDAR.height_m] for sensor in sensors])
    origins = (stands - poses.positions[pose]) @ poses.rotations[pose]
    return np.repeat(origins, beams, axis=0), directions @ poses.rotations[pose]


def _windows(object_: Object, poses: PoseSet, sensors: list[SensorConfiguration]) -> NDArray[np.bool_]:
    """Flags (n, k * r) of the beams that meet the ball around the bounding box of the mesh, at each pose."""
    assert poses.rotations is not None
    assert poses.positions is not None
    middle = 0.5 * (object_.vertices.min(axis=0) + object_.vertices.max(axis=0))
    radius = np.linalg.norm(object_.vertices - middle, axis=1).max()
    there = poses.rotations @ middle + poses.positions
    assert scene.LIDAR.height_m is not None
    reach = np.sqrt(np.maximum(radius**2 - (there[:, 2] - scene.LIDAR.height_m) ** 2, 0.0))
    windows = []
    for sensor in sensors:
        x, y = there[:, 0] - sensor.x, there[:, 1] - sensor.y
        half = np.arcsin(np.minimum(reach / np.hypot(x, y), 1.0))
        apart = sensor.yaw_rad + scene.LIDAR.grid.angles - np.arctan2(y, x)[:, None]
        windows.append(np.abs(np.remainder(apart + np.pi, 2.0 * np.pi) - np.pi) <= half[:, None])
    return np.concatenate(windows, axis=1)


def _by_kernel(kernel: rtcore_scene.EmbreeScene, rays: list[tuple[NDArray[np.float32], ...]]) -> None:
    for origins, directions in rays:
        kernel.run(origins, directions, query="DISTANCE")


def _by_api(api: RayMeshIntersector, poses: PoseSet, sensors: list[SensorConfiguration]) -> Floats:
    """Ranges (n, k, r) by trimesh and embreex."""
    ranges = np.full((len(poses), len(sensors) * scene.LIDAR.grid.beams), np.inf)
    for pose in range(len(poses)):
        origins, directions = _rays(poses, pose, sensors)
        points, ray, _ = api.intersects_location(origins, directions, multiple_hits=False)
        ranges[pose, ray] = np.linalg.norm(points - origins[ray], axis=1)
    return ranges.reshape(len(poses), len(sensors), -1)


def _compare(ours: list[Prediction], theirs: Floats) -> None:
    ranges = np.stack([prediction.dense() for prediction in ours], axis=1)
    both = np.isfinite(ranges) & np.isfinite(theirs)
    one = np.isfinite(ranges) != np.isfinite(theirs)
    require(bool(both.any()), "no beam hits the cup")
    off = np.abs(ranges[both] - theirs[both])
    require(one.mean() <= _SILHOUETTES, f"{one.sum()} of {one.size} beams hit in one and miss in the other")
    require((off > _TOLERANCE_M).mean() <= _SILHOUETTES, f"{(off > _TOLERANCE_M).sum()} ranges differ by {off.max()} m")
