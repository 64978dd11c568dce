"""Points of the object that the lidar would see at each pose, from the predictions of a service.

A client has no mesh: the service stores meshes and does not return them. Its predictions show the same outline.
"""

import math
from collections.abc import Sequence

from voa_client import Client
from voa_msgs.lidars import Lidar, LidarPreset
from voa_msgs.scenarios import PredictionsRequest, Scenario

_MOST_RANGES = 2_000_000
"""Most predicted ranges that are requested for a picture."""
_GRID_M = 0.001
Points = list[tuple[float, float]]


def predicted_points(client: Client, scenario: Scenario) -> list[Points] | None:
    """Points with x and y in the world frame, metres, for each pose; at most one in each square of 1 mm.

    They are seen from the places of the scenario, or from as many of them, evenly chosen, as give 2 million ranges.

    Returns:
        One list for each pose; None: already one place would give more ranges than that.

    Raises:
        VoaClientError: the service cannot be reached, or refuses.
    """
    presets = {preset.name: preset for preset in client.lidars().items}
    angles = _angles(scenario.lidar, presets)
    most = _MOST_RANGES // (len(scenario.poses) * len(angles))
    if most == 0:
        return None
    step = math.ceil(len(scenario.sensors) / most)
    stands = scenario.sensors[::step]
    predictions = client.predict(scenario.id, PredictionsRequest(sensors=[stand.name for stand in stands]))
    points: list[set[tuple[int, int]]] = [set() for _ in scenario.poses]
    for stand, by_pose in zip(stands, predictions.ranges, strict=True):
        directions = [(math.cos(stand.yaw_rad + angle), math.sin(stand.yaw_rad + angle)) for angle in angles]
        for seen, ranges in zip(points, by_pose, strict=True):
            for (right, ahead), distance in zip(directions, ranges, strict=True):
                if distance is not None:
                    x, y = stand.x + distance * right, stand.y + distance * ahead
                    if _is_inside(scenario, x, y):
                        seen.add((round(x / _GRID_M), round(y / _GRID_M)))
    return [[(x * _GRID_M, y * _GRID_M) for x, y in sorted(seen)] for seen in points]


def _angles(lidar: Lidar, presets: dict[str, LidarPreset]) -> Sequence[float]:
    """Angles of the beams in the lidar's frame, radians; fields of the scenario override those of its preset."""
    preset = presets.get(lidar.preset or "")
    beams = lidar.beams if lidar.beams is not None or preset is None else preset.beams
    first = lidar.angle_min if lidar.angle_min is not None or preset is None else preset.angle_min
    step = lidar.angle_increment if lidar.angle_increment is not None or preset is None else preset.angle_increment
    return [(first or 0.0) + (step or 0.0) * beam for beam in range(beams or 0)]


def _is_inside(scenario: Scenario, x: float, y: float) -> bool:
    """True if a point lies in the workspace, or there is none."""
    space = scenario.workspace
    return space is None or (space.min[0] <= x <= space.max[0] and space.min[1] <= y <= space.max[1])
