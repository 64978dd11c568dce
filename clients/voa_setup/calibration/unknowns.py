"""The unknown of a calibration, odometry's origin or the lidar's mount, and its relation to the poses of the lidar.

The lidar of stop i is at `L_i = O R_i M` in the world: O is the origin, the pose of the odometry's frame in the world;
R_i the pose of the robot by odometry; M the mount, the pose of the lidar on the robot. A scan measures L_i. With M
known, `O = L_i (R_i M)^-1`; with O known, `M = (O R_i)^-1 L_i`. One stop gives three numbers, not the six of both.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal

from voa_setup.calibration.planar import Floats, composed, inverse

Estimated = Literal["origin", "mount"]
"""The pose that is estimated: odometry's origin in the world, or the lidar's mount on the robot."""


@dataclass(frozen=True, eq=False)
class Unknown:
    """Pose to be estimated, with the poses that are taken for known.

    Attributes:
        estimated: which one it is.
        origin, mount: (3,) as the mapping states them; the estimated one is only compared with the result.
        robots: (3,) pose of the robot by odometry at each stop.
    """

    estimated: Estimated
    origin: Floats
    mount: Floats
    robots: Sequence[Floats]

    @property
    def stated(self) -> Floats:
        """Estimated pose as the mapping states it, (3,)."""
        return self.origin if self.estimated == "origin" else self.mount

    def of_lidar(self, lidars: Floats) -> Floats:
        """Compute the unknown pose (k, 3) from poses (k, 3) of the lidar at the first stop."""
        if self.estimated == "origin":
            return composed(lidars, inverse(composed(self.robots[0], self.mount)))
        return composed(inverse(composed(self.origin, self.robots[0])), lidars)

    def lidars(self, first: Floats, stop: int) -> Floats:
        """Compute the poses of the lidar at a stop from its poses (k, 3) at the first stop."""
        if stop == 0:
            return first
        if self.estimated == "origin":
            moved = composed(inverse(composed(self.robots[0], self.mount)), composed(self.robots[stop], self.mount))
            return composed(first, moved)
        moved = composed(composed(self.origin, self.robots[stop]), inverse(composed(self.origin, self.robots[0])))
        return composed(moved, first)
