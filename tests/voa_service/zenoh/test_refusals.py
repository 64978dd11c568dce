"""Failures of looks that a session did not accept: each reason of an update is explained in a sentence of its own."""

from typing import get_args

import pytest

from voa_msgs.sessions import Reason
from voa_service.zenoh.refusals import not_accepted

REASONS = [reason for reason in get_args(Reason) if reason != "nearest"]
"""Reasons for which a look is not accepted; `nearest` is one for which it is."""


@pytest.mark.parametrize("reason", REASONS)
def test_every_reason_is_explained(reason: str) -> None:
    failure = not_accepted(reason)
    assert (failure.kind, failure.status, failure.more) == ("not-accepted", 422, {"reason": reason})
    assert failure.detail.startswith(f"the belief is unchanged, {reason}: ")
    assert "says more" not in failure.detail


def test_no_two_reasons_have_one_explanation() -> None:
    assert len({not_accepted(reason).detail.partition(": ")[2] for reason in REASONS}) == len(REASONS)


def test_an_unknown_reason_refers_to_the_response() -> None:
    assert not_accepted("other").detail == "the belief is unchanged, other: the response to the update says more"
