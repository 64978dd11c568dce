"""A call under way: a method takes parameters out of the payload, and the rest is the body, all of which must fit."""

import json
from typing import Any

import pytest

from tests.support.serving import Service
from voa_msgs.keys import Attachment
from voa_msgs.sessions import OutcomeRequest
from voa_service.failures import InvalidRequest
from voa_service.rpc.calls import Call

OUTCOME = {"grasp": "G1", "success": True}


def call(service: Service, fields: dict[str, Any]) -> Call:
    return Call(dict(fields), Attachment(), service.inside, size=100)


@pytest.mark.parametrize("name", ["session", "id"])
def test_a_session_is_named_by_either_field_and_is_no_part_of_the_body(service: Service, name: str) -> None:
    own = call(service, {name: "S"} | OUTCOME)
    assert own.session() == "S"
    assert own.body(OutcomeRequest) == OutcomeRequest(grasp="G1", success=True)


def test_an_object_or_scenario_is_named_by_its_id(service: Service) -> None:
    own = call(service, {"id": "X", "limit": 1})
    assert (own.id(), own.fields) == ("X", {"limit": 1})


def test_a_call_that_names_both_fields_keeps_the_id_for_the_body_to_refuse(service: Service) -> None:
    own = call(service, {"session": "S", "id": "T"} | OUTCOME)
    assert own.session() == "S"
    with pytest.raises(InvalidRequest, match="id: no such field"):
        own.body(OutcomeRequest)


@pytest.mark.parametrize("fields", [{}, {"session": 7}, {"session": ""}])
def test_a_call_without_its_session_is_refused_with_the_name_of_the_field(
    service: Service, fields: dict[str, Any]
) -> None:
    with pytest.raises(InvalidRequest, match=r"^body\.session: "):
        call(service, fields).session()


def test_the_history_keeps_the_fields_that_no_parameter_took(service: Service) -> None:
    own = call(service, {"session": "S"} | OUTCOME)
    own.session()
    assert json.loads(own.received()) == OUTCOME
