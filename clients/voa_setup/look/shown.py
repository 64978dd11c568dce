"""Content of the page: a scenario with its outlines, rests and prior, worked out once for all sections."""

from collections.abc import Sequence
from dataclasses import dataclass

from voa_fleet.world.frames import Floats
from voa_fleet.world.meshes import Mesh
from voa_msgs.scenarios import ScenarioRequest
from voa_setup.look.groups import PoseGroup, group_poses
from voa_setup.look.outlines import outlines


@dataclass(frozen=True, eq=False)
class Shown:
    """A scenario with all that its page draws.

    Attributes:
        scenario: as in the scenario file.
        mesh: in metres, in the object's frame.
        heights_m: heights of the scan planes over the table, without repetitions; the lidar's own first.
        outlines: of the object at each pose (outer) in each scan plane (inner), (s, 2, 2) segments, metres; s = 0 where
            the plane misses the object.
        groups: poses by the way in which the object rests.
        prior: probability of each pose; None: the scenario has a model of the prior.
    """

    scenario: ScenarioRequest
    mesh: Mesh
    heights_m: tuple[float, ...]
    outlines: Sequence[Sequence[Floats]]
    groups: Sequence[PoseGroup]
    prior: Sequence[float] | None


def shown(scenario: ScenarioRequest, mesh: Mesh) -> Shown:
    """Work out what the page of a scenario draws.

    Raises:
        ValueError: no scan plane has a height, or a pose has no position or orientation.
    """
    stated = [scenario.lidar.height_m, *(sensor.height_m for sensor in scenario.sensors)]
    heights = tuple(dict.fromkeys(height for height in stated if height is not None))
    if not heights:
        raise ValueError("expected lidar.height_m, the height of the scan plane over the table, got none")
    if any(pose.position is None or pose.quaternion_wxyz is None for pose in scenario.poses):
        raise ValueError("expected position and quaternion_wxyz of every pose, got a pose with its name alone")
    prior = [1.0 / len(scenario.poses)] * len(scenario.poses) if scenario.prior is None else scenario.prior
    return Shown(
        scenario,
        mesh,
        heights,
        list(zip(*(outlines(mesh, scenario.poses, height) for height in heights), strict=True)),
        group_poses(scenario.poses),
        prior if isinstance(prior, list) else None,
    )
