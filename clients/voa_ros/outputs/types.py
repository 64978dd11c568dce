"""Types of the messages for ROS tools, and definitions of those that rosbags does not know.

The definitions of `vision_msgs` 4 and `moveit_msgs` 2 are lists of their fields. Their hashes (REP-2011) are computed
from them, and a wrong field, name or order gives another hash.
"""

DETECTION = "vision_msgs/msg/Detection3D"
POSE_ARRAY = "geometry_msgs/msg/PoseArray"
POSE_STAMPED = "geometry_msgs/msg/PoseStamped"
MARKER_ARRAY = "visualization_msgs/msg/MarkerArray"
GRASP = "moveit_msgs/msg/Grasp"
FLOAT = "std_msgs/msg/Float64"
TYPES = (DETECTION, POSE_ARRAY, POSE_STAMPED, MARKER_ARRAY, GRASP, FLOAT)
"""Every type that is published."""

DEFINITIONS = {
    "vision_msgs/msg/ObjectHypothesis": "string class_id\nfloat64 score\n",
    "vision_msgs/msg/ObjectHypothesisWithPose": (
        "vision_msgs/ObjectHypothesis hypothesis\ngeometry_msgs/PoseWithCovariance pose\n"
    ),
    "vision_msgs/msg/BoundingBox3D": "geometry_msgs/Pose center\ngeometry_msgs/Vector3 size\n",
    DETECTION: (
        "std_msgs/Header header\n"
        "vision_msgs/ObjectHypothesisWithPose[] results\n"
        "vision_msgs/BoundingBox3D bbox\n"
        "string id\n"
    ),
    "moveit_msgs/msg/GripperTranslation": (
        "geometry_msgs/Vector3Stamped direction\nfloat32 desired_distance\nfloat32 min_distance\n"
    ),
    GRASP: (
        "string id\n"
        "trajectory_msgs/JointTrajectory pre_grasp_posture\n"
        "trajectory_msgs/JointTrajectory grasp_posture\n"
        "geometry_msgs/PoseStamped grasp_pose\n"
        "float64 grasp_quality\n"
        "moveit_msgs/GripperTranslation pre_grasp_approach\n"
        "moveit_msgs/GripperTranslation post_grasp_retreat\n"
        "moveit_msgs/GripperTranslation post_place_retreat\n"
        "float32 max_contact_force\n"
        "string[] allowed_touch_objects\n"
    ),
}
"""Definitions by type, each after those that it contains, in the format "ros2msg"."""
