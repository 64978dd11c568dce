"""Grasps as `moveit_msgs/msg/Grasp`, and the best grasp as a `geometry_msgs/msg/PoseStamped`.

`moveit_msgs` has arrays of grasps only in services and actions (`GraspPlanning`, `Pickup`), and none for a topic. So
each grasp is a message of its own on one topic, the best first, and at most ten of them: subscribers of ROS keep ten
messages by default, so that none of a batch is lost.

The pose is that of a tool frame: its origin midway between the fingertips at the moment when they close, z along the
approach, x along the closing direction. MoveIt expects the pose of the link that carries the gripper: a fixed transform
of the robot's own between both remains to be applied.
"""

from voa_msgs.grasp_geometry import GraspGeometry, grasp_geometry
from voa_msgs.rankings import RankedGrasps
from voa_msgs.scenarios import Grasp, Scenario
from voa_ros.outputs.fields import Fields, header, point, pose
from voa_scene.rotations import cross, of_axes, unit

MOST_GRASPS = 10
"""Most grasps that are published at a version: the queue of a subscriber of ROS, by default."""
_APPROACH_M, _LEAST_APPROACH_M = 0.10, 0.05
_UP = (0.0, 0.0, 1.0)


def grasp_messages(scenario: Scenario, ranked: RankedGrasps, frame_id: str) -> list[Fields]:
    """Make the messages of the grasps that are best under a belief, the best first.

    Grasps with the expected score 0, and grasps whose `data` does not state the geometry by the convention of
    `voa_msgs.grasp_geometry`, are left out: a message without a pose would send the arm to the world's origin.
    """
    known = geometries(scenario)
    best = [grasp for grasp in ranked.grasps if grasp.expected_score > 0.0 and grasp.name in known]
    return [_message(each.name, known[each.name], each.expected_score, frame_id) for each in best[:MOST_GRASPS]]


def best_grasp(scenario: Scenario, name: str | None, frame_id: str) -> Fields | None:
    """Make the pose of the tool at the best grasp; None: there is none, or its geometry is not known."""
    geometry = None if name is None else geometries(scenario).get(name)
    return None if geometry is None else {"header": header(frame_id), "pose": _tool(geometry)}


def geometries(scenario: Scenario) -> dict[str, GraspGeometry]:
    """Return the geometry of each grasp that states it, by name."""
    known = {grasp.name: _geometry(grasp) for grasp in scenario.grasps}
    return {name: geometry for name, geometry in known.items() if geometry is not None}


def _geometry(grasp: Grasp) -> GraspGeometry | None:
    try:
        return grasp_geometry(grasp.data)
    except ValueError:
        return None


def _tool(geometry: GraspGeometry) -> Fields:
    approach, closing = unit(geometry.approach), unit(geometry.closing)
    side = unit(cross(approach, closing))
    return pose(geometry.tool_centre_point, of_axes(cross(side, approach), side, approach))


def _message(name: str, geometry: GraspGeometry, score: float, frame_id: str) -> Fields:
    return {
        "id": name,
        "grasp_pose": {"header": header(frame_id), "pose": _tool(geometry)},
        "grasp_quality": score,
        "pre_grasp_approach": _translation(unit(geometry.approach), frame_id),
        "post_grasp_retreat": _translation(_UP, frame_id),
        "post_place_retreat": _translation(_UP, frame_id),
    }


def _translation(direction: tuple[float, float, float], frame_id: str) -> Fields:
    return {
        "direction": {"header": header(frame_id), "vector": point(direction)},
        "desired_distance": _APPROACH_M,
        "min_distance": _LEAST_APPROACH_M,
    }
