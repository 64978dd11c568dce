"""Beliefs as a `vision_msgs/msg/Detection3D` and as a `geometry_msgs/msg/PoseArray`."""

from collections.abc import Sequence
from dataclasses import dataclass

from voa_msgs.scenarios import Scenario
from voa_msgs.sessions import Session
from voa_ros.outputs.fields import Fields, header, point, pose, turned
from voa_scene.shapes import Vector

MOST_HYPOTHESES = 200
"""Most poses in a detection: the likeliest."""
MOST_POSES = 500
"""Most poses in a PoseArray: the likeliest."""
_HELD = 0.95
_NO_ROTATION = (1.0, 0.0, 0.0, 0.0)


@dataclass(frozen=True)
class Bounds:
    """Bounding box of a mesh in its own frame: its smallest and largest x, y, z, metres."""

    low: Vector
    high: Vector


def detection(scenario: Scenario, session: Session, frame_id: str, bounds: Bounds | None = None) -> Fields:
    """Make the detection of the object: a hypothesis for each pose, the likeliest first.

    Args:
        scenario: of the session; its `spread` is the covariance of each hypothesis.
        session: whose belief is shown; poses of probability 0 are left out.
        frame_id: of the scenario's world.
        bounds: of the object's mesh, for the bounding box at the likeliest pose; None: the box has the size 0.
    """
    order = likeliest(session.belief)[:MOST_HYPOTHESES]
    covariance = _covariance(scenario)
    results = [
        {
            "hypothesis": {"class_id": scenario.poses[index].name, "score": session.belief[index]},
            "pose": {"pose": _pose(scenario, index), "covariance": covariance},
        }
        for index in order
    ]
    box = {"center": pose((0.0, 0.0, 0.0), _NO_ROTATION)} if not order else _box(scenario, order[0], bounds)
    return {"header": header(frame_id, session.updated_at), "results": results, "bbox": box, "id": session.id}


def pose_array(scenario: Scenario, session: Session, frame_id: str) -> Fields:
    """Make a PoseArray of the fewest poses that hold 95 % of the belief, the likeliest first."""
    chosen: list[int] = []
    held = 0.0
    for index in likeliest(session.belief)[:MOST_POSES]:
        if held >= _HELD:
            break
        held += session.belief[index]
        chosen.append(index)
    return {"header": header(frame_id), "poses": [_pose(scenario, index) for index in chosen]}


def likeliest(belief: Sequence[float]) -> list[int]:
    """Return the indices of the poses with a probability above 0, the likeliest first, equals in their order."""
    return sorted((index for index, share in enumerate(belief) if share > 0.0), key=lambda index: -belief[index])


def _pose(scenario: Scenario, index: int) -> Fields:
    """Write a pose of a scenario; one without geometry is that of the world's origin."""
    listed = scenario.poses[index]
    return pose(listed.position or (0.0, 0.0, 0.0), listed.quaternion_wxyz or _NO_ROTATION)


def _covariance(scenario: Scenario) -> list[float]:
    covariance = [0.0] * 36
    if scenario.spread is not None:
        covariance[0] = covariance[7] = scenario.spread.xy_m**2
        covariance[35] = scenario.spread.yaw_rad**2
    return covariance


def _box(scenario: Scenario, index: int, bounds: Bounds | None) -> Fields:
    """Bounding box of the object at a pose: it turns with the object."""
    listed = scenario.poses[index]
    if bounds is None or listed.position is None or listed.quaternion_wxyz is None:
        return {"center": _pose(scenario, index)}
    a, b, c, d = listed.quaternion_wxyz
    middle = turned(
        (a, b, c, d),
        (
            (bounds.low[0] + bounds.high[0]) / 2.0,
            (bounds.low[1] + bounds.high[1]) / 2.0,
            (bounds.low[2] + bounds.high[2]) / 2.0,
        ),
    )
    centre = [own + moved for own, moved in zip(listed.position, middle, strict=True)]
    size = [high - low for low, high in zip(bounds.low, bounds.high, strict=True)]
    return {"center": pose(centre, listed.quaternion_wxyz), "size": point(size)}
