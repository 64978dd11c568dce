"""The recommended place as a `geometry_msgs/msg/PoseStamped` of the robot's base, as Nav2 takes it for a goal."""

from voa_msgs.rankings import Look, Ranking
from voa_msgs.scenarios import Scenario
from voa_ros.motions import Motion, Planar, composed, inverse
from voa_ros.outputs.fields import Fields, header, pose
from voa_ros.robot_places import AmclPlace, OdometryPlace, PlanarPose
from voa_ros.robots import RobotMapping
from voa_scene.rotations import about_z


def place(scenario: Scenario, ranking: Ranking, mapping: RobotMapping) -> Fields | None:
    """Make the pose of the robot from which its lidar looks as the ranking recommends.

    Args:
        scenario: lists the sensor configurations.
        ranking: recommends a look, or a grasp.
        mapping: states the mount of the lidar, and the frame of the localisation.

    Returns:
        None: the ranking recommends to grasp, or a place that the scenario does not list.
    """
    advice = ranking.recommendation
    if not isinstance(advice, Look):
        return None
    for sensor in scenario.sensors:
        if sensor.name == advice.sensor:
            base = base_pose(sensor, mapping)
            return {
                "header": header(localisation_frame(mapping)),
                "pose": pose((base.x, base.y, 0.0), about_z(base.yaw_rad)),
            }
    return None


def base_pose(lidar: Planar, mapping: RobotMapping) -> Motion:
    """Compute the pose of the robot's base in the frame of its localisation, from that of its lidar in the world.

    It undoes the mount of the lidar on the robot, and the origin of the localisation's frame in the world.
    """
    base = composed(lidar, inverse(mapping.lidar))
    origin = localisation_origin(mapping)
    return base if origin is None else composed(inverse(origin), base)


def localisation_origin(mapping: RobotMapping) -> PlanarPose | None:
    """Return the pose in the world of the frame in which the robot knows its pose; None: that is the world itself."""
    return mapping.place.origin if isinstance(mapping.place, OdometryPlace | AmclPlace) else None


def localisation_frame(mapping: RobotMapping) -> str:
    """Return the name of the frame in which the robot knows its pose."""
    outputs = mapping.outputs
    if outputs.place_frame_id is not None:
        return outputs.place_frame_id
    match mapping.place:
        case AmclPlace():
            return "map"
        case OdometryPlace():
            return "odom"
        case _:
            return outputs.frame_id
