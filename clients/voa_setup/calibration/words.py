"""Result of a calibration in sentences, and as lines for `robots.toml`."""

import math

from voa_ros.robots import RobotMapping
from voa_setup.calibration.estimating import Estimate
from voa_setup.calibration.planar import planar, wrapped
from voa_setup.calibration.searching import Solution, Undetermined
from voa_setup.calibration.unknowns import Estimated

ONE_STOP = {
    "origin": (
        "The lidar's mount (x, y, yaw) was taken for exact: an error of it is now in the origin. One stop measures "
        "where the lidar stood, which does not separate an error of the mount from one of the origin."
    ),
    "mount": (
        "Odometry's origin, and the robot's pose by odometry, were taken for exact: their errors are now in the mount. "
        "One stop measures where the lidar stood, which does not separate an error of the origin from one of the mount."
    ),
}
"""Limits of a calibration, by the pose that was estimated."""
_MOST_OTHERS = 5
_COARSE_M, _COARSE_RAD = 0.005, math.radians(1.0)
"""Standard deviations above which more stops are recommended."""


def is_determined(estimate: Estimate) -> bool:
    """True if the scans determine the pose in every direction."""
    return not estimate.best.undetermined


def sentences(estimate: Estimate, mapping: RobotMapping, estimated: Estimated) -> list[str]:
    """Describe a result: data, pose with uncertainty, distance from the mapping, sign, alternatives, and limits."""
    best = estimate.best
    lines = [
        f"{mapping.name}: {estimate.stops} stop{'s' * (estimate.stops > 1)}, {best.beams} beams on the object, "
        f"measured and predicted ranges differ by {1e3 * best.sigma_m:.1f} mm (standard deviation)"
    ]
    if best.undetermined:
        lines += [_undetermined(each) for each in best.undetermined]
        lines.append(
            "No pose is stated, because it would be arbitrary: choose a pose or side at which the object's outline "
            "looks different from every side (a handle, a corner), or record more stops around it."
        )
    else:
        lines += [f"{estimated}: {_pose(best)}", _away(best, mapping, estimated)]
        if best.std[:2].max() > _COARSE_M or best.std[2] > _COARSE_RAD:
            lines.append(
                "That is coarse for a look (a lidar's beams are 5 to 10 mm apart at this distance): add stops at other "
                "sides of the object."
            )
    lines.append(_sign(estimate, mapping))
    lines += _others(estimate, estimated)
    lines.append(ONE_STOP[estimated])
    return lines


def _pose(solution: Solution) -> str:
    x, y, yaw = solution.pose
    std_x, std_y, std_yaw = solution.std
    return (
        f"x = {x:.4f} +- {std_x:.4f} m, y = {y:.4f} +- {std_y:.4f} m, yaw = {math.degrees(yaw):.2f} +- "
        f"{math.degrees(std_yaw):.2f} degrees (one standard deviation)"
    )


def _away(solution: Solution, mapping: RobotMapping, estimated: Estimated) -> str:
    stated = planar(mapping.lidar if estimated == "mount" else getattr(mapping.place, "origin", mapping.lidar))
    off = solution.pose - stated
    turned = math.degrees(abs(wrapped(off[2:])[0]))
    return f"That is {1e3 * math.hypot(off[0], off[1]):.0f} mm and {turned:.1f} degrees from what the mapping states."


def _undetermined(direction: Undetermined) -> str:
    match direction.coordinate:
        case "bearing":
            return (
                f"NOT DETERMINED: from which side the object was seen (+- {math.degrees(direction.std):.0f} degrees): "
                "turning the lidar about the object hardly changes the scan"
            )
        case "distance":
            return f"NOT DETERMINED: the distance from the object (+- {1e3 * direction.std:.0f} mm)"
        case "turn":
            return f"NOT DETERMINED: the lidar's own yaw (+- {math.degrees(direction.std):.0f} degrees)"


def _mounting(*, upside_down: bool) -> str:
    return f"{'upside down' if upside_down else 'upright'} (upside_down = {str(upside_down).lower()})"


def _sign(estimate: Estimate, mapping: RobotMapping) -> str:
    mounting = _mounting(upside_down=estimate.best.upside_down)
    if not estimate.sign_known:
        return (
            f"Sign of the yaw: not determined, a lidar of the other sign fits as well; {mounting} is assumed, as the "
            "mapping states; check it on the robot. A stop at another side of the object, or an object without mirror "
            "symmetry, decides."
        )
    if estimate.best.upside_down != mapping.lidar.upside_down:
        return f"Sign of the yaw: the lidar is mounted {mounting}, unlike the mapping states."
    return f"Sign of the yaw: {mounting}, as the mapping states; the other sign does not fit."


def _others(estimate: Estimate, estimated: Estimated) -> list[str]:
    same = [each for each in estimate.others if each.upside_down == estimate.best.upside_down]
    if not same:
        return []
    listed = [f"  {estimated}: {_pose(each)}" for each in same[:_MOST_OTHERS]]
    more = [f"  and {len(same) - _MOST_OTHERS} more"] if len(same) > _MOST_OTHERS else []
    return [
        "! The scans fit other poses about as well (the object looks alike from several sides); the one nearest "
        "to what the mapping states was taken. Also possible:",
        *listed,
        *more,
    ]


def toml_lines(estimate: Estimate, mapping: RobotMapping, estimated: Estimated) -> list[str]:
    """Write the lines that the entry of the robot in `robots.toml` should have."""
    best = estimate.best
    x, y, yaw = (f"{value:.4f}" for value in best.pose)
    std_x, std_y, std_yaw = best.std
    comment = f"  # standard deviations: x {std_x:.4f} m, y {std_y:.4f} m, yaw {std_yaw:.4f} rad"
    if estimated == "mount":
        return [f"lidar = {{ {_mount(mapping, best, x, y, yaw)} }}{comment}", *_with_other_sign(estimate, mapping)]
    lines = [f"origin = {{ x = {x}, y = {y}, yaw_rad = {yaw} }}{comment}; in [robot.place]"]
    if best.upside_down != mapping.lidar.upside_down:
        own = mapping.lidar
        lines.append(f"lidar = {{ {_mount(mapping, best, f'{own.x:g}', f'{own.y:g}', f'{own.yaw_rad:.6g}')} }}")
    return lines


def _with_other_sign(estimate: Estimate, mapping: RobotMapping) -> list[str]:
    """Comment with the mount if the lidar has the other sign of the yaw, where the scans do not exclude that."""
    other = next((each for each in estimate.others if each.upside_down != estimate.best.upside_down), None)
    if other is None:
        return []
    x, y, yaw = (f"{value:.4f}" for value in other.pose)
    mounting = "hangs upside down" if other.upside_down else "stands upright"
    return [f"# if the lidar {mounting}: lidar = {{ {_mount(mapping, other, x, y, yaw)} }}"]


def _mount(mapping: RobotMapping, best: Solution, x: str, y: str, yaw: str) -> str:
    height = "" if mapping.lidar.height_m is None else f", height_m = {mapping.lidar.height_m:g}"
    hangs = ", upside_down = true" if best.upside_down else ""
    return f"x = {x}, y = {y}, yaw_rad = {yaw}{height}{hangs}"
