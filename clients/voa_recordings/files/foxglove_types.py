"""Message types of Foxglove that recordings hold, as ROS 2 defines them: scenes of shapes, and frames.

Foxglove reads `foxglove_msgs/msg/SceneUpdate` by the definition in the file, as it does `foxglove.SceneUpdate`; as
messages of ROS 2 they can be read by every reader of rosbag2 files, too.
"""

from rosbags.interfaces.typing import Typesdict
from rosbags.typesys import get_types_from_msg

PACKAGE = "foxglove_msgs/msg"
SCENE = f"{PACKAGE}/SceneUpdate"
FRAMES = f"{PACKAGE}/FrameTransforms"

_PLACED = "geometry_msgs/Pose pose"
_COLOURED = "foxglove_msgs/Color color"
_POINTS = ("geometry_msgs/Point[] points", _COLOURED, "foxglove_msgs/Color[] colors", "uint32[] indices")
_STAMPED = "builtin_interfaces/Time timestamp"

_FIELDS: dict[str, tuple[str, ...]] = {
    "Color": ("float64 r", "float64 g", "float64 b", "float64 a"),
    "KeyValuePair": ("string key", "string value"),
    "ArrowPrimitive": (
        _PLACED, "float64 shaft_length", "float64 shaft_diameter", "float64 head_length", "float64 head_diameter",
        _COLOURED,
    ),
    "CubePrimitive": (_PLACED, "geometry_msgs/Vector3 size", _COLOURED),
    "SpherePrimitive": (_PLACED, "geometry_msgs/Vector3 size", _COLOURED),
    "CylinderPrimitive": (
        _PLACED, "geometry_msgs/Vector3 size", "float64 bottom_scale", "float64 top_scale", _COLOURED,
    ),
    "LinePrimitive": (
        "uint8 LINE_STRIP=0", "uint8 LINE_LOOP=1", "uint8 LINE_LIST=2", "uint8 type", _PLACED, "float64 thickness",
        "bool scale_invariant", *_POINTS,
    ),
    "TriangleListPrimitive": (_PLACED, *_POINTS),
    "TextPrimitive": (
        _PLACED, "bool billboard", "float64 font_size", "bool scale_invariant", _COLOURED, "string text",
    ),
    "ModelPrimitive": (
        _PLACED, "geometry_msgs/Vector3 scale", _COLOURED, "bool override_color", "string url", "string media_type",
        "uint8[] data",
    ),
    "SceneEntityDeletion": (_STAMPED, "uint8 MATCHING_ID=0", "uint8 ALL=1", "uint8 type", "string id"),
    "SceneEntity": (
        _STAMPED, "string frame_id", "string id", "builtin_interfaces/Duration lifetime", "bool frame_locked",
        "foxglove_msgs/KeyValuePair[] metadata", "foxglove_msgs/ArrowPrimitive[] arrows",
        "foxglove_msgs/CubePrimitive[] cubes", "foxglove_msgs/SpherePrimitive[] spheres",
        "foxglove_msgs/CylinderPrimitive[] cylinders", "foxglove_msgs/LinePrimitive[] lines",
        "foxglove_msgs/TriangleListPrimitive[] triangles", "foxglove_msgs/TextPrimitive[] texts",
        "foxglove_msgs/ModelPrimitive[] models",
    ),
    "SceneUpdate": ("foxglove_msgs/SceneEntityDeletion[] deletions", "foxglove_msgs/SceneEntity[] entities"),
    "FrameTransform": (
        _STAMPED, "string parent_frame_id", "string child_frame_id", "geometry_msgs/Vector3 translation",
        "geometry_msgs/Quaternion rotation",
    ),
    "FrameTransforms": ("foxglove_msgs/FrameTransform[] transforms",),
}  # fmt: skip
"""Fields of each type, and its constants, in the order of their bytes."""


def foxglove_types() -> Typesdict:
    """Parse the types, for a typestore that has those of `geometry_msgs` and `builtin_interfaces`."""
    types: Typesdict = {}
    for name, fields in _FIELDS.items():
        types |= get_types_from_msg("\n".join(fields), f"{PACKAGE}/{name}")
    return types
