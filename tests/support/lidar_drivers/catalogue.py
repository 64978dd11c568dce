"""All drivers that are modelled, by name."""

from tests.support.lidar_drivers.driver import Driver
from tests.support.lidar_drivers.hls_lfcd import LDS_01
from tests.support.lidar_drivers.ld08 import LDS_02
from tests.support.lidar_drivers.ldlidar_stl import LD19
from tests.support.lidar_drivers.sick_picoscan import PICOSCAN150
from tests.support.lidar_drivers.sick_tim import TIM571
from tests.support.lidar_drivers.sllidar import A1, A2, C1, S2
from tests.support.lidar_drivers.urg import URG_04LX, UST_10LX
from tests.support.lidar_drivers.ydlidar import TG15, X4

_ALL = (LDS_01, LDS_02, LD19, X4, TG15, A1, A2, C1, S2, UST_10LX, URG_04LX, TIM571, PICOSCAN150)
DRIVERS: dict[str, Driver] = {driver.name: driver for driver in _ALL}
