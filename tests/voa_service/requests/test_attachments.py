"""Attachments of requests on Zenoh: read within bounds, and the place of a scan is taken from one of two sources."""

from typing import Any

import pytest

from voa_msgs.keys import Attachment
from voa_service.failures import InvalidRequest
from voa_service.requests.attachments import add_place, read_attachment

POSE = {"x": 0.5, "y": 0.0, "yaw_rad": 0.0}


@pytest.mark.parametrize("none", [None, b""])
def test_a_request_without_an_attachment_has_an_empty_one(none: bytes | None) -> None:
    assert read_attachment(none) == Attachment()


def test_the_fields_of_an_attachment_are_read() -> None:
    attachment = read_attachment(b'{"id": "k", "sensor": "Q1", "wire": 1}')
    assert attachment == Attachment(id="k", sensor="Q1", wire=1)


@pytest.mark.parametrize(
    ("content", "words"),
    [
        (b" " * 65_537, "at most 65536 bytes, got 65537"),
        (b"not json", "^attachment: .* at character 0"),
        (b'{"id": ""}', r"^attachment\.id: "),
        (b'{"colour": 1}', r"^attachment\.colour: no such field"),
        (b'{"sensor": "Q1", "sensor_pose": {"x": 0.0, "y": 0.0, "yaw_rad": 0.0}}', "at most one of"),
    ],
)
def test_an_attachment_that_cannot_be_used_is_refused(content: bytes, words: str) -> None:
    with pytest.raises(InvalidRequest, match=words):
        read_attachment(content)


@pytest.mark.parametrize(
    ("attachment", "added"),
    [
        (Attachment(), {}),
        (Attachment(id="k"), {}),
        (Attachment(sensor="Q1"), {"sensor": "Q1"}),
        (Attachment.model_validate({"sensor_pose": POSE}), {"sensor_pose": POSE}),
    ],
)
def test_the_place_of_an_attachment_becomes_a_field_of_the_body(attachment: Attachment, added: dict[str, Any]) -> None:
    body: dict[str, Any] = {"scan": {"ranges": [0.5]}}
    add_place(body, attachment)
    assert body == {"scan": {"ranges": [0.5]}} | added


@pytest.mark.parametrize("stated", [{"sensor": "Q2"}, {"sensor_pose": POSE}])
def test_a_place_in_the_body_and_in_the_attachment_is_refused(stated: dict[str, Any]) -> None:
    with pytest.raises(InvalidRequest, match="both say where the scan was taken"):
        add_place(dict(stated), Attachment(sensor="Q1"))


def test_a_null_place_in_the_body_gives_way_to_the_attachment() -> None:
    body: dict[str, Any] = {"sensor": None}
    add_place(body, Attachment(sensor="Q1"))
    assert body == {"sensor": "Q1"}
