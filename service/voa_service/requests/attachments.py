"""Attachments of requests on Zenoh: JSON beside the payload, for the place of a scan, an idempotency key and more."""

from typing import Any

from pydantic import ValidationError

from voa_msgs.keys import Attachment
from voa_service.access.callers import Caller
from voa_service.access.gate import Gate
from voa_service.access.roles import Call
from voa_service.failures import Failure, InvalidRequest, Unauthenticated, of_message
from voa_service.requests.bodies import json_value
from voa_service.settings import Limits

_MOST_BYTES = 65_536


def read_attachment(attachment: bytes | None) -> Attachment:
    """Read the attachment of a request; an empty `Attachment` where there is none.

    Raises:
        Failure: larger than 64 KiB, not JSON, or with fields that an attachment does not have.
    """
    if not attachment:
        return Attachment.model_construct()  # a tenth of a small call's CPU time is saved: there is nothing to check
    if len(attachment) > _MOST_BYTES:
        raise InvalidRequest(f"expected an attachment of at most {_MOST_BYTES} bytes, got {len(attachment)}")
    try:
        fields = json_value(attachment, Limits())
    except Failure as failure:
        raise InvalidRequest(f"attachment: {failure.detail}") from failure
    try:
        return Attachment.model_validate(fields)
    except ValidationError as error:
        raise of_message(Attachment, error, "attachment") from error


def identified(
    gate: Gate, attachment: bytes | None, call: Call, origin: str, group: str | None = None
) -> tuple[Attachment, Caller]:
    """Read the attachment of a request, and identify its caller by the key in it.

    An attachment that cannot be read has no key: it is refused, and counted, as a request without one.

    Args:
        gate: identifies callers.
        attachment: of the request; None: there is none.
        call: that is made.
        origin: of the request, as far as it is known without a key.
        group: of origins, counted together besides; None: of none.

    Raises:
        Failure: the attachment cannot be read, or there is no valid key though the service needs one.
    """
    try:
        beside = read_attachment(attachment)
    except Failure as failure:
        try:
            gate.identify(None, call, origin, group)
        except Unauthenticated as refused:
            raise Unauthenticated(f"no key can be read: {failure.detail}") from refused
        raise
    return beside, gate.identify(beside.key, call, origin, group)


def add_place(fields: dict[str, Any], attachment: Attachment) -> None:
    """Add the place where a scan was taken, `sensor` or `sensor_pose`, from the attachment to the fields of its body.

    Raises:
        Failure: the body and the attachment both name a place.
    """
    place = attachment.model_dump(include={"sensor", "sensor_pose"}, exclude_none=True)
    if not place:
        return
    if fields.get("sensor") is not None or fields.get("sensor_pose") is not None:
        raise InvalidRequest("the payload and its attachment both say where the scan was taken: expected one of them")
    fields.update(place)
