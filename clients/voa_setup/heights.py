"""Heights of the scan plane: at which of them the lidar sees the object, and distinguishes most pairs of poses."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from voa_core.checks import Floats
from voa_core.lidars import BeamGrid, LidarModel
from voa_core.lidars import SensorConfiguration as CoreSensor
from voa_core.mistakes.picking import evenly
from voa_core.poses import PoseSet as CorePoses
from voa_core.prediction import predictor_of_mesh
from voa_core.scans import NO_RETURN
from voa_msgs.geometry import SensorConfiguration
from voa_msgs.lidars import LidarPreset
from voa_msgs.scenarios import Pose
from voa_setup.errors import InvalidOption
from voa_setup.mesh import SetupMesh
from voa_setup.motions import matrices_of_poses

_LOWEST_M, _STEP_M = 0.01, 0.005  # lidars of small robots scan from a centimetre up
_MOST_HEIGHTS = 60
_MOST_POSES = 120
_FEWEST_BEAMS = 3  # that hit the object, or differ, before they count as evidence
_SIGMAS = 3.0
_MORE = 0.02  # share of pairs by which a suggestion must be better to be mentioned
_ERROR_M = 0.002  # of the scan plane's height on a real robot


@dataclass(frozen=True)
class HeightSight:
    """Sight of the object by the lidar at one height of its scan plane.

    Attributes:
        height_m: of the scan plane over the table, metres.
        seen: share of the poses, weighted by the prior, that some place sees by at least 3 beams.
        pairs: share of the pairs of poses that the scans of some place distinguish: at least 3 beams differ by more
            than three standard deviations of the lidar's noise.
        unseen: names of the poses that no place sees.
    """

    height_m: float
    seen: float
    pairs: float
    unseen: tuple[str, ...]


def sights(
    mesh: SetupMesh,
    poses: Sequence[Pose],
    prior: Sequence[float],
    places: Sequence[SensorConfiguration],
    lidar: LidarPreset,
    heights_m: Sequence[float] | None = None,
) -> list[HeightSight]:
    """Predict scans at several heights, and count the poses that are seen and the pairs that are distinguished.

    Args:
        mesh: of the object.
        poses: of the scenario; of more than 120 an even selection.
        prior: probability of each pose.
        places: from which the lidar looks.
        lidar: with its beams and noise.
        heights_m: to compare, metres; None: every 5 mm from 1 cm to the top of the object.
    """
    index = evenly(len(poses), _MOST_POSES)
    shown = [poses[p] for p in index]
    weights = np.array(prior)[index] / np.array(prior)[index].sum()
    core = core_poses(shown)
    model = lidar_model(lidar)
    predictor = predictor_of_mesh(mesh.object_, core, model)
    heights = _candidates(mesh, shown) if heights_m is None else list(heights_m)
    stands = [CoreSensor(place.name, place.x, place.y, place.yaw_rad) for place in places]
    results = []
    for height in heights:
        seen = np.zeros(len(shown), dtype=bool)
        apart = np.zeros((len(shown), len(shown)), dtype=bool)
        for stand in stands:
            scans = predictor.predict(CoreSensor(stand.name, stand.x, stand.y, stand.yaw_rad, height)).ranges
            seen |= (scans < NO_RETURN).sum(axis=1) >= _FEWEST_BEAMS
            apart |= _distinguished(scans, model)
        pairs = len(shown) * (len(shown) - 1)
        unseen = tuple(pose.name for pose, is_seen in zip(shown, seen, strict=True) if not is_seen)
        results.append(
            HeightSight(height, round(float(weights @ seen), 9), float(apart.sum()) / pairs if pairs else 1.0, unseen)
        )
    return results


def suggested(candidates: Sequence[HeightSight]) -> HeightSight:
    """Return the height at which most poses are seen, and then most pairs distinguished, also 5 mm above and below.

    Of equals the one in the middle of the longest run is returned, so that an error of the height does least harm.
    """
    steady = []
    for index in range(len(candidates)):
        beside = candidates[max(0, index - 1) : index + 2]
        # A plane that sees every pose counts as such only with a margin for the error of its own height.
        steady.append((round(min(each.seen for each in beside), 6), round(np.mean([each.pairs for each in beside]), 2)))
    best = max(steady)
    runs: list[list[int]] = []
    for index, value in enumerate(steady):
        if value == best:
            if runs and runs[-1][-1] == index - 1:
                runs[-1].append(index)
            else:
                runs.append([index])
    run = max(runs, key=len)
    return candidates[run[len(run) // 2]]


def check_height(sight: HeightSight, candidates: Sequence[HeightSight]) -> None:
    """Check that a scan plane sees the object at some pose; raises InvalidOption with the heights that would work."""
    if sight.seen > 0.0:
        return
    working = [each.height_m for each in candidates if each.seen > 0.0]
    if not working:
        raise InvalidOption("no height of the scan plane sees the object: is it too small for the lidar, or too far?")
    all_poses = [each.height_m for each in candidates if not each.unseen]
    every = f"; from {min(all_poses):g} to {max(all_poses):g} it is seen at every pose" if all_poses else ""
    raise InvalidOption(
        f"--height {sight.height_m:g}: the scan plane misses the object at every pose. It sees the object from "
        f"{min(working):g} to {max(working):g} m{every}; the suggestion is --height {suggested(candidates).height_m:g}"
    )


def describe_height(chosen: HeightSight, best: HeightSight) -> str:
    """Describe in a sentence what the lidar can distinguish at the chosen height, and at a better one."""
    sentence = (
        f"The scan plane is {1e3 * chosen.height_m:g} mm over the table, where the lidar can distinguish "
        f"{chosen.pairs:.0%} of the pairs of poses"
    )
    if best.pairs > chosen.pairs + _MORE or len(best.unseen) < len(chosen.unseen):
        seen = f"all but {len(best.unseen)} poses" if best.unseen else "every pose"
        sentence += f"; with --height {best.height_m:g} it would distinguish {best.pairs:.0%}, and see {seen}"
    return f"{sentence}. If your lidar is at another height over the object's table, state it with --height."


def core_poses(poses: Sequence[Pose]) -> CorePoses:
    """Make the poses of the mathematics from poses with a position and an orientation."""
    return CorePoses.from_arrays(
        [pose.name for pose in poses],
        np.array([pose.position for pose in poses]),
        np.array([pose.quaternion_wxyz for pose in poses]),
    )


def _candidates(mesh: SetupMesh, poses: Sequence[Pose]) -> list[float]:
    """Heights to compare: from 1 cm, or half of the lowest pose's height, to the top of the highest pose, metres."""
    tops = [float((mesh.mesh.vertices @ row[2, :3] + row[2, 3]).max()) for row in matrices_of_poses(poses)]
    lowest = min(_LOWEST_M, round(min(tops) / 2.0, 3))
    step = max(_STEP_M, round((max(tops) - lowest) / _MOST_HEIGHTS, 3))
    return [round(float(height), 4) for height in np.arange(max(lowest, 0.001), max(tops), step)]


def lidar_model(lidar: LidarPreset, height_m: float | None = None) -> LidarModel:
    """Make the lidar of the mathematics from a preset; the scan plane has no height unless it is stated, metres."""
    grid = BeamGrid(lidar.beams, lidar.angle_min, lidar.angle_increment)
    return LidarModel(
        grid, lidar.range_min, lidar.range_max, height_m, lidar.zero, lidar.noise_m, lidar.noise_ratio, lidar.dropout
    )


def _distinguished(scans: Floats, lidar: LidarModel) -> NDArray[np.bool_]:
    """Flags (n, n) of the pairs of scans (n, c) of which at least 3 beams differ by more than the noise explains."""
    noise = _SIGMAS * np.maximum(lidar.noise_m, lidar.noise_ratio * np.where(scans < NO_RETURN, scans, 0.0)) + _ERROR_M
    coded = np.where(scans < NO_RETURN, scans, lidar.range_max)
    flags = np.zeros((len(scans), len(scans)), dtype=bool)
    for pose in range(len(scans)):
        limit = np.maximum(noise, noise[pose])
        flags[pose] = (np.abs(coded - coded[pose]) > limit).sum(axis=1) >= _FEWEST_BEAMS
    return flags
