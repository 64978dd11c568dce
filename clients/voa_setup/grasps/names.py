"""Names of grasps: from where the hand comes, and on which side of the object it grips."""

import math
from collections import Counter
from collections.abc import Sequence

from voa_msgs.grasp_geometry import GraspGeometry

_SECTORS = ("+x", "+x+y", "+y", "-x+y", "-x", "-x-y", "-y", "+x-y")
_MIDDLE_M = 0.012
"""Distance from the object's place below which a grasp is in the middle."""


def grasp_names(grasps: Sequence[GraspGeometry], centre: tuple[float, float]) -> list[str]:
    """Name grasps, each differently: `from above at +x`, `from the side at 90`, `slanting from 45`.

    Degrees are the bearing, counter-clockwise from +x, from which the hand comes, to the nearest 5. Grasps
    that would share a name get their closing direction, their height, and at last a number.

    Args:
        grasps: in the world frame.
        centre: x, y about which the object lies, metres.
    """
    names = [_kind(grasp, centre) for grasp in grasps]
    for qualifier in (_closing, _height):
        shared = {name for name, times in Counter(names).items() if times > 1}
        names = [
            f"{name}, {qualifier(grasp)}" if name in shared else name for name, grasp in zip(names, grasps, strict=True)
        ]
    return _numbered(names)


def _numbered(names: Sequence[str]) -> list[str]:
    totals, seen = Counter(names), Counter[str]()
    unique = []
    for name in names:
        seen[name] += 1
        unique.append(f"{name} ({seen[name]})" if totals[name] > 1 else name)
    return unique


def _kind(grasp: GraspGeometry, centre: tuple[float, float]) -> str:
    x, y, z = grasp.approach
    steepness = -z / math.hypot(x, y, z)
    if steepness > 0.9:
        place = grasp.tool_centre_point
        aside = place[0] - centre[0], place[1] - centre[1]
        if math.hypot(*aside) < _MIDDLE_M:
            return "from above in the middle"
        return f"from above at {_SECTORS[round(_degrees(*aside) / 45.0) % 8]}"
    bearing = 5 * round(_degrees(-x, -y) / 5.0) % 360
    return f"slanting from {bearing}" if steepness > 0.3 else f"from the side at {bearing}"


def _closing(grasp: GraspGeometry) -> str:
    x, y, z = grasp.closing
    if abs(z) > 0.7 * math.hypot(x, y, z):
        return "closing upright"
    return f"closing along {5 * round(_degrees(x, y) / 5.0) % 180}"


def _height(grasp: GraspGeometry) -> str:
    return f"{round(1e3 * grasp.tool_centre_point[2])} mm high"


def _degrees(x: float, y: float) -> float:
    return math.degrees(math.atan2(y, x))
