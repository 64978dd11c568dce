"""Numbers, probabilities and frames as messages of ROS 2."""

from typing import Any

from voa_recordings.files.foxglove_types import FRAMES
from voa_recordings.files.ros_types import RosTypes
from voa_recordings.scenes.series import NUMBER, NUMBERS, frames_message, number_message, probabilities_message

STORE = RosTypes().store


def test_a_number_is_a_float64() -> None:
    message: Any = STORE.deserialize_cdr(number_message(STORE, 0.25), NUMBER)
    assert message.data == 0.25


def test_probabilities_are_an_array_with_the_names_of_the_poses() -> None:
    message: Any = STORE.deserialize_cdr(probabilities_message(STORE, ["A", "B"], [0.75, 0.25]), NUMBERS)
    assert list(message.data) == [0.75, 0.25]
    (dimension,) = message.layout.dim
    assert (dimension.label, dimension.size) == ("A, B", 2)


def test_frames_lie_in_the_world() -> None:
    frames = {"voa/s1/object": ((1.0, 2.0, 3.0), (0.5, 0.5, -0.5, 0.5))}
    message: Any = STORE.deserialize_cdr(frames_message(STORE, frames, 5_000_000_007), FRAMES)
    (frame,) = message.transforms
    assert (frame.parent_frame_id, frame.child_frame_id) == ("world", "voa/s1/object")
    assert (frame.timestamp.sec, frame.timestamp.nanosec) == (5, 7)
    assert (frame.translation.x, frame.translation.y, frame.translation.z) == (1.0, 2.0, 3.0)
    assert (frame.rotation.w, frame.rotation.x, frame.rotation.y, frame.rotation.z) == (0.5, 0.5, -0.5, 0.5)
