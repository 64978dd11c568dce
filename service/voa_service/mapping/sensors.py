"""Sensor configurations and sensor poses: from messages to the mathematics."""

from collections.abc import Sequence

from voa_core.errors import InvalidInput
from voa_core.lidars import SensorConfiguration, SensorUncertainty
from voa_core.scenario import Scenario
from voa_msgs.geometry import CandidateSensor
from voa_msgs.geometry import SensorConfiguration as SensorMessage
from voa_msgs.looks import AtPlace


def sensor_of(sensor: SensorMessage) -> SensorConfiguration:
    """Build a listed sensor configuration from its message."""
    return SensorConfiguration(sensor.name, sensor.x, sensor.y, sensor.yaw_rad, sensor.height_m, sensor.cost)


def candidates(
    scenario: Scenario, wanted: Sequence[str | CandidateSensor] | None, *, differ: bool = True
) -> tuple[SensorConfiguration, ...]:
    """Return the sensor configurations that a request names or describes; None: all that the scenario lists.

    Args:
        scenario: whose listed configurations can be named.
        wanted: names of listed configurations, or sensor poses; a pose without a name is called by its index.
        differ: True if no name may occur twice.

    Raises:
        UnknownName: the scenario lists no configuration of that name.
        InvalidInput: two configurations have one name.
    """
    if wanted is None:
        return scenario.sensors
    sensors = tuple(_candidate(scenario, index, item) for index, item in enumerate(wanted))
    if differ and len({sensor.name for sensor in sensors}) != len(sensors):
        raise InvalidInput("sensors", "names that differ", "a name twice")
    return sensors


def _candidate(scenario: Scenario, index: int, item: str | CandidateSensor) -> SensorConfiguration:
    if isinstance(item, str):
        return scenario.sensor(item)
    name = str(index) if item.name is None else item.name
    return SensorConfiguration(name, item.x, item.y, item.yaw_rad, item.height_m, item.cost)


def place_of(scenario: Scenario, request: AtPlace) -> tuple[SensorConfiguration, SensorUncertainty | None]:
    """Return the sensor configuration or pose of a look, and its uncertainty; None: it is exact.

    Raises:
        UnknownName: the scenario lists no configuration of that name.
    """
    if request.sensor_pose is None:
        return scenario.sensor(request.sensor or ""), None
    pose = request.sensor_pose
    sensor = SensorConfiguration("sensor_pose", pose.x, pose.y, pose.yaw_rad, pose.height_m)
    if pose.std is None or pose.std.xy_m == pose.std.yaw_rad == 0.0:
        return sensor, None
    return sensor, SensorUncertainty(pose.std.xy_m, pose.std.yaw_rad)
