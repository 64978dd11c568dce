"""Scenarios whose object spreads about its poses, and scans of them."""

import math
from typing import Any

from tests.support.serving import Json, Service, as_scan, box_obj, mesh_scenario

SPREAD: Json = {"xy_m": 0.005, "yaw_rad": 0.05}
BEAM: Json = {"rule": "beam", "temper": 0.01}
"""Update rule that leaves several poses possible after a look."""


def spread_body(object_id: str, **changes: Any) -> Json:
    """Scenario of a box at two yaws that spreads by 5 mm and 3 degrees, under the rule `beam`."""
    return mesh_scenario(object_id, **({"name": "spread", "spread": SPREAD, "update": BEAM} | changes))


def spread_scenario(service: Service, **changes: Any) -> str:
    """Store `spread_body(**changes)` with its mesh, and return its id."""
    return service.create(spread_body(service.upload(box_obj()), **changes))


def seen_from(service: Service, sensor: str | Json, pose: str, off_m: float = 0.0, **options: Any) -> Json:
    """Request with the scan that the box gives at a pose, with every range longer by `off_m`.

    Args:
        service: in which the box is.
        sensor: name of a sensor configuration, or a sensor pose, possibly with its `std`.
        pose: A or B.
        off_m: metres.
        options: fields of the scan.
    """
    exact = service.create(mesh_scenario(service.upload(box_obj())))
    named = isinstance(sensor, str)
    place = sensor if isinstance(sensor, str) else {key: value for key, value in sensor.items() if key != "std"}
    predicted = service.post(f"/v1/scenarios/{exact}/predictions", {"sensors": [place]})
    ranges = predicted["ranges"][0][predicted["poses"].index(pose)]
    longer = [None if value is None else value + off_m for value in ranges]
    return {"sensor" if named else "sensor_pose": sensor, "scan": as_scan(longer) | options}


def turned_body(object_id: str, **changes: Any) -> Json:
    """Scenario of the box at five yaws, with grasps for three directions, in which every look leaves doubts."""
    yaws = [0.0, 0.35, 0.7, 1.05, 1.4]
    names = ["A", *(f"P{number}" for number in range(1, 4)), "B"]
    turned: Json = {
        "name": "turned",
        "poses": [
            {
                "name": name,
                "position": [0.0, 0.0, 0.0],
                "quaternion_wxyz": [math.cos(yaw / 2.0), 0.0, 0.0, math.sin(yaw / 2.0)],
            }
            for name, yaw in zip(names, yaws, strict=True)
        ],
        "grasps": [{"name": f"G{number}"} for number in range(3)],
        "scores": {
            "attempts": 20,
            "successes": [[19, 11, 2, 1, 0], [1, 9, 18, 12, 3], [0, 1, 4, 10, 19]],
        },
        "spread": {"xy_m": 0.008, "yaw_rad": 0.15},
        "update": {"rule": "beam", "temper": 0.1},
    }
    return spread_body(object_id, **(turned | changes))
