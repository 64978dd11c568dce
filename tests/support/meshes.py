"""Mesh files made of primitives, in any unit, and their stable poses without a service."""

from pathlib import Path

import numpy as np
import trimesh

from voa_core.checks import Floats
from voa_core.stable_poses import propose_stable_poses
from voa_msgs.objects import StablePose
from voa_setup.mesh import SetupMesh, read_mesh


def box(x: float, y: float, z: float) -> trimesh.Trimesh:
    """A box of the given size, its middle at the origin."""
    part: trimesh.Trimesh = trimesh.creation.box((x, y, z))
    return part


def cylinder(radius: float, height: float) -> trimesh.Trimesh:
    """A cylinder along z, its middle at the origin."""
    part: trimesh.Trimesh = trimesh.creation.cylinder(radius, height)
    return part


def joined(*parts: trimesh.Trimesh) -> trimesh.Trimesh:
    """Several parts as one mesh, in which they may overlap."""
    whole = trimesh.util.concatenate(parts)
    assert isinstance(whole, trimesh.Trimesh)
    return whole


def mug() -> trimesh.Trimesh:
    """A mug of 8 x 10 cm with a bottom, and a handle at +x."""
    wall = trimesh.creation.annulus(0.036, 0.04, 0.09)
    bottom = trimesh.creation.cylinder(0.04, 0.01, transform=moved(0.0, 0.0, -0.05))
    handle = trimesh.creation.box((0.03, 0.012, 0.06), transform=moved(0.054, 0.0, 0.0))
    return joined(wall, bottom, handle)


def moved(x: float, y: float, z: float) -> Floats:
    """The matrix (4, 4) of a motion without a turn."""
    matrix = np.eye(4)
    matrix[:3, 3] = x, y, z
    return matrix


def written(mesh: trimesh.Trimesh, file: Path) -> Path:
    """Write a mesh file of the type of its ending."""
    mesh.export(file)
    return file


def setup_mesh(mesh: trimesh.Trimesh, folder: Path) -> SetupMesh:
    """Read a mesh as `voa new` does."""
    return read_mesh(written(mesh, folder / "object.stl"), scale=1.0)


def stable_poses(mesh: SetupMesh) -> list[StablePose]:
    """The stable poses that the service would propose."""
    return [
        StablePose(
            position=list(pose.position), quaternion_wxyz=list(pose.quaternion_wxyz), probability=pose.probability
        )
        for pose in propose_stable_poses(mesh.object_)
    ]
