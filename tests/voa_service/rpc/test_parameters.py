"""Parameters of remote calls: defaults and bounds as those of HTTP's paths and queries."""

from typing import Any

import pytest
from pydantic import ValidationError

from voa_msgs.base import Message
from voa_service.rpc.parameters import Identified, InSession, NoParameters, ObjectPage, Page, Reachable


def test_a_list_has_a_hundred_items_from_the_start_unless_the_call_says_otherwise() -> None:
    assert Page() == Page(limit=100, after=None)
    assert ObjectPage().model_dump(exclude_none=True) == {"limit": 100}


@pytest.mark.parametrize(
    ("kind", "accepted"),
    [
        (Page, {"limit": 1}),
        (Page, {"limit": 1_000, "after": "7"}),
        (ObjectPage, {"sha256": "0" * 64, "type": "obj", "scale": 0.001, "up": "+Y"}),
        (Reachable, {"grasps": ["G1"]}),
        (Reachable, {"grasps": None}),
        (Identified, {"id": "x"}),
        (InSession, {"session": "x"}),
        (NoParameters, {}),
    ],
)
def test_parameters_within_bounds_are_accepted(kind: type[Message], accepted: dict[str, Any]) -> None:
    assert kind.model_validate(accepted).model_dump(exclude_unset=True) == accepted


@pytest.mark.parametrize(
    ("kind", "refused"),
    [
        (Page, {"limit": 0}),
        (Page, {"limit": 1_001}),
        (Page, {"limit": "10"}),
        (Page, {"sha256": "0" * 64}),
        (ObjectPage, {"scale": 0.0}),
        (ObjectPage, {"up": "+X"}),
        (Identified, {"id": ""}),
        (InSession, {}),
        (NoParameters, {"id": "x"}),
    ],
)
def test_parameters_beyond_bounds_are_refused(kind: type[Message], refused: dict[str, Any]) -> None:
    with pytest.raises(ValidationError):
        kind.model_validate(refused)
