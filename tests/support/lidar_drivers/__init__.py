"""Generators of what the ROS 2 drivers of common lidars really publish, written from the drivers' behaviour.

One file per family of drivers; each says which driver it stands for, where that was read, what is modelled, and what
could not be verified. `DRIVERS` has all of them by name, `Scene` is the world they look at, and `lost_packets` and
`flicker` damage what they published.
"""

from tests.support.lidar_drivers.catalogue import DRIVERS
from tests.support.lidar_drivers.damage import flicker, lost_packets
from tests.support.lidar_drivers.driver import Driver
from tests.support.lidar_drivers.scene import Scene

__all__ = ["DRIVERS", "Driver", "Scene", "flicker", "lost_packets"]
