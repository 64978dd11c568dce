import numpy as np
import pytest
from rosbags.typesys import Stores, get_typestore

from tests.support.ros_tools import StockDecoder
from voa_ros.outputs.types import DETECTION, FLOAT, GRASP, MARKER_ARRAY, POSE_ARRAY, TYPES
from voa_service.ros_tools.encoding import Encoder, UnknownFields

PUBLISHED = {
    DETECTION: "RIHS01_ddd703be132ab0b69d33121f1bb034132bfbb3b0ac5f9fb1516005ba1c8a265b",
    GRASP: "RIHS01_5369669de88fe85f7bca5dc948d70fe6e86fe93c531d590ecbcd9c21385aa593",
}
"""Hashes of the definitions that rosbags does not have.

Clients of rmw_zenoh by other projects have the first in their keys. No project publishes the second: it is the hash of
fields whose names, order and types equal those of moveit_msgs' own file, and of the package make87-messages-ros2 0.2.2
for Jazzy, when they were compared.
"""


@pytest.fixture(scope="module")
def encoder() -> Encoder:
    return Encoder()


@pytest.mark.parametrize("name", PUBLISHED)
def test_definitions_have_the_hashes_of_those_they_were_compared_with(encoder: Encoder, name: str) -> None:
    assert encoder.type(name).rihs == PUBLISHED[name]


@pytest.mark.parametrize("release", [Stores.ROS2_HUMBLE, Stores.ROS2_JAZZY, Stores.ROS2_KILTED])
def test_types_are_equal_in_every_release_that_rosbags_knows(encoder: Encoder, release: Stores) -> None:
    types = get_typestore(release)
    for name in TYPES:
        if name in types.fielddefs:
            assert types.hash_rihs01(name) == encoder.type(name).rihs


def test_a_stock_decoder_reads_an_empty_message_of_each_type(encoder: Encoder) -> None:
    decoder = StockDecoder()
    for name in TYPES:
        decoder.decode(name, encoder.encode(name, {}))


def test_fields_that_are_left_out_are_zero(encoder: Encoder) -> None:
    grasp = StockDecoder().decode(GRASP, encoder.encode(GRASP, {"id": "G1", "allowed_touch_objects": ["table"]}))
    assert (grasp.id, grasp.grasp_quality, grasp.allowed_touch_objects) == ("G1", 0.0, ["table"])
    assert grasp.pre_grasp_posture.joint_names == []


def test_numbers_and_arrays_of_numbers_are_written_by_their_types(encoder: Encoder) -> None:
    covariance = [float(number) for number in range(36)]
    fields = {"results": [{"hypothesis": {"class_id": "P1", "score": 0.25}, "pose": {"covariance": covariance}}]}
    (result,) = StockDecoder().decode(DETECTION, encoder.encode(DETECTION, fields)).results
    assert (result.hypothesis.class_id, result.hypothesis.score) == ("P1", 0.25)
    assert list(np.asarray(result.pose.covariance)) == covariance


def test_the_bytes_are_little_endian_cdr_with_its_header(encoder: Encoder) -> None:
    assert encoder.encode(FLOAT, {"data": 0.5}).hex() == "00010000" + "000000000000e03f"


@pytest.mark.parametrize(
    ("name", "fields"),
    [
        (FLOAT, {"date": 1.0}),
        (POSE_ARRAY, {"header": {"frame": "world"}}),
        (MARKER_ARRAY, {"markers": [{"colour": {}}]}),
    ],
)
def test_a_field_that_the_type_does_not_have_is_refused(encoder: Encoder, name: str, fields: dict[str, object]) -> None:
    with pytest.raises(UnknownFields, match="expected fields of the type"):
        encoder.encode(name, fields)
