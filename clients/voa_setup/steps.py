"""Steps that need no grasps: rests, poses, places and the scan plane, from the choices of a person.

The making of a scenario and the previews of its parts take them alike, so that both show the same poses and places.
"""

from collections.abc import Sequence
from pathlib import Path
from tempfile import TemporaryDirectory

from voa_client import Client
from voa_msgs.geometry import SensorConfiguration
from voa_msgs.lidars import LidarPreset
from voa_msgs.objects import StablePose
from voa_setup.choices import Choices
from voa_setup.errors import InvalidOption
from voa_setup.heights import check_height, describe_height, sights, suggested
from voa_setup.mesh import SetupMesh, write_mesh
from voa_setup.places import check_places, fitting_radius, ring
from voa_setup.poses import PoseSet, make_poses


def stable_poses_of(client: Client, mesh: SetupMesh) -> list[StablePose]:
    """Return the stable poses of the mesh, as the service computes them."""
    with TemporaryDirectory(prefix="voa-new-") as temporary:
        file = Path(temporary) / f"{mesh.name}.obj"
        write_mesh(mesh.mesh, file)
        return list(client.stable_poses(client.create_object(file).id).items)


def chosen_poses(choices: Choices, mesh: SetupMesh, stable: Sequence[StablePose]) -> PoseSet:
    """Make the poses of a scenario; raises InvalidOption where no rest is left."""
    return make_poses(
        mesh,
        stable,
        yaws_deg=choices.yaws_deg,
        positions=choices.positions,
        least_probability=choices.least_probability,
        rests=choices.rests,
    )


def preset_named(client: Client, name: str) -> LidarPreset:
    """Return the preset of that name; raises InvalidOption with the names that exist."""
    presets = {preset.name: preset for preset in client.lidars().items}
    if name not in presets:
        raise InvalidOption(f"--lidar {name}: there is no such lidar; there are: {', '.join(sorted(presets))}")
    return presets[name]


def chosen_places(choices: Choices, mesh: SetupMesh, poses: PoseSet, lidar: LidarPreset) -> list[SensorConfiguration]:
    """Return the places, on a ring around the middle of the positions or as listed; raises InvalidOption."""
    if not isinstance(choices.places, int):
        places = list(choices.places)
        check_places(places, mesh, poses.poses, lidar)
        return places
    xs, ys = zip(*choices.positions, strict=True)
    centre = round(sum(xs) / len(xs), 6), round(sum(ys) / len(ys), 6)
    radius = fitting_radius(choices.radius_m, mesh, poses.poses, lidar, centre)
    return ring(choices.places, radius, centre)


def chosen_height(
    choices: Choices, mesh: SetupMesh, poses: PoseSet, places: Sequence[SensorConfiguration], lidar: LidarPreset
) -> tuple[float, list[str]]:
    """Return the height of the scan plane, and notes about it; raises InvalidOption for a height that sees nothing."""
    candidates = sights(mesh, poses.poses, poses.prior, places, lidar)
    best = suggested(candidates)
    chosen = best
    if choices.height_m is not None:
        chosen = sights(mesh, poses.poses, poses.prior, places, lidar, [choices.height_m])[0]
    check_height(chosen, candidates)
    return chosen.height_m, [] if len(poses.poses) == 1 else [describe_height(chosen, best)]
