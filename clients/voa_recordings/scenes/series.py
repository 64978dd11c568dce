"""Frames, numbers and probabilities of a version, as messages of ROS 2 that viewers draw over time."""

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from rosbags.typesys.store import Typestore

from voa_recordings.files.foxglove_types import FRAMES
from voa_recordings.scenes.scene_message import WORLD
from voa_ros.messages import NANOSECONDS
from voa_scene.shapes import Quaternion, Vector

NUMBER = "std_msgs/msg/Float64"
NUMBERS = "std_msgs/msg/Float64MultiArray"


def number_message(store: Typestore, value: float) -> bytes:
    """Write a number as a `std_msgs/msg/Float64` in CDR."""
    return bytes(store.serialize_cdr(store.types[NUMBER](data=value), NUMBER))


def probabilities_message(store: Typestore, poses: Sequence[str], belief: Sequence[float]) -> bytes:
    """Write a belief as a `std_msgs/msg/Float64MultiArray` in CDR.

    Args:
        store: of ROS 2's types.
        poses: their names, which the label of the array's dimension lists.
        belief: probability of each, in the same order.
    """
    count = len(belief)
    dimension = store.types["std_msgs/msg/MultiArrayDimension"](label=", ".join(poses), size=count, stride=count)
    layout = store.types["std_msgs/msg/MultiArrayLayout"](dim=[dimension], data_offset=0)
    message = store.types[NUMBERS](layout=layout, data=np.array(belief, dtype=np.float64))
    return bytes(store.serialize_cdr(message, NUMBERS))


def frames_message(store: Typestore, frames: Mapping[str, tuple[Vector, Quaternion]], at_ns: int) -> bytes:
    """Write frames as a `foxglove_msgs/msg/FrameTransforms` in CDR.

    Args:
        store: with the types of Foxglove.
        frames: position (metres) and rotation in the world frame of each, by its name.
        at_ns: time of the frames, nanoseconds since 1970.
    """
    seconds, nanoseconds = divmod(at_ns, NANOSECONDS)
    transforms: list[Any] = []
    for name, ((x, y, z), (w, i, j, k)) in frames.items():
        transforms.append(
            store.types["foxglove_msgs/msg/FrameTransform"](
                timestamp=store.types["builtin_interfaces/msg/Time"](sec=seconds, nanosec=nanoseconds),
                parent_frame_id=WORLD,
                child_frame_id=name,
                translation=store.types["geometry_msgs/msg/Vector3"](x=x, y=y, z=z),
                rotation=store.types["geometry_msgs/msg/Quaternion"](x=i, y=j, z=k, w=w),
            )
        )
    return bytes(store.serialize_cdr(store.types[FRAMES](transforms=transforms), FRAMES))
