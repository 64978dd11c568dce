"""Scene of the benchmarks: a cup with a handle, poses on a table, an LDS-01 around it."""

import numpy as np
import trimesh

from voa_core.checks import Floats
from voa_core.geometry import quaternion_of_matrix, turn
from voa_core.lidars import BeamGrid, LidarModel, SensorConfiguration
from voa_core.objects import Object
from voa_core.poses import PoseSet
from voa_core.prediction import Prediction, predictor_of_mesh

LIDAR = LidarModel(
    BeamGrid(360, 0.0, np.radians(1.0)),
    range_min=0.12,
    range_max=3.5,
    height_m=0.02,
    zero="missing",
    noise_m=0.005,
    noise_ratio=0.01,
    dropout=0.02,
)

_CUP_FINENESS = {"1k": (36, 2), "10k": (96, 7), "100k": (300, 24)}
SIZES = tuple(_CUP_FINENESS)
_TILTS = 6


def cup(size: str) -> Object:
    """A closed cup, 13 cm with its handle, of about `size` faces (one of SIZES)."""
    around, along = _CUP_FINENESS[size]
    profile = np.array([[0.0, 0.0], [0.04, 0.0], [0.045, 0.1], [0.041, 0.1], [0.036, 0.006], [0.0, 0.006]])
    steps = np.linspace(0.0, len(profile) - 1.0, (len(profile) - 1) * along + 1)
    fine = np.column_stack([np.interp(steps, np.arange(len(profile)), axis) for axis in profile.T])
    body = trimesh.creation.revolve(fine, sections=around)
    handle = trimesh.creation.torus(0.028, 0.006, major_sections=around // 2, minor_sections=around // 6)
    handle.apply_transform([[1, 0, 0, 0.055], [0, 0, -1, 0], [0, 1, 0, 0.05], [0, 0, 0, 1]])
    mesh = trimesh.boolean.union([body, handle], engine="manifold")
    return Object.from_arrays(mesh.vertices, mesh.faces)


def poses(object_: Object, n: int, *, planar: bool, seed: int = 1) -> PoseSet:
    """`n` poses with the lowest vertex on the table: six tilts at any yaw and place, or each its own tilt."""
    random = np.random.default_rng(seed)
    tilts = [_random_rotation(random) for _ in range(_TILTS if planar else n)]
    positions, quaternions = [], []
    for index in range(n):
        rotation = turn(random.uniform(0.0, 2.0 * np.pi)) @ tilts[index % len(tilts)]
        lowest = float((object_.vertices @ tilts[index % len(tilts)][2]).min())
        positions.append([*random.uniform(-0.03, 0.03, 2), -lowest])
        quaternions.append(quaternion_of_matrix(rotation))
    return PoseSet.from_arrays([f"P{index}" for index in range(n)], positions, quaternions)


def sensors(k: int, seed: int = 2) -> list[SensorConfiguration]:
    """`k` places 0.2 to 0.45 m from the origin, facing anywhere."""
    random = np.random.default_rng(seed)
    around, away = random.uniform(0.0, 2.0 * np.pi, k), random.uniform(0.2, 0.45, k)
    yaws = random.uniform(-np.pi, np.pi, k)
    return [
        SensorConfiguration(f"Q{i}", float(away[i] * np.cos(around[i])), float(away[i] * np.sin(around[i])), yaw)
        for i, yaw in enumerate(yaws.tolist())
    ]


def predictions(n: int, k: int, size: str = "10k") -> list[Prediction]:
    """The scans of `n` planar poses of the cup from `k` sensors."""
    object_ = cup(size)
    predictor = predictor_of_mesh(object_, poses(object_, n, planar=True), LIDAR)
    return [predictor.predict(sensor) for sensor in sensors(k)]


def belief(n: int, seed: int = 3) -> Floats:
    """An uneven belief over `n` poses, none impossible."""
    shares = np.random.default_rng(seed).gamma(0.3, size=n) + 1e-6
    held: Floats = shares / shares.sum()
    return held


def scores(m: int, n: int, seed: int = 4) -> Floats:
    """Grasp scores (m, n) that vary smoothly over the poses, in [0, 1]."""
    random = np.random.default_rng(seed)
    phases, speeds = random.uniform(0.0, 2.0 * np.pi, (m, 1)), random.integers(1, 6, (m, 1))
    return 0.5 + 0.5 * np.sin(phases + speeds * np.linspace(0.0, 2.0 * np.pi, n))


def _random_rotation(random: np.random.Generator) -> Floats:
    q, r = np.linalg.qr(random.normal(size=(3, 3)))
    q = q * np.sign(np.diag(r))
    rotation: Floats = q * np.linalg.det(q)
    return rotation
