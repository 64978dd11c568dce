"""Update rules on the wire: each rule has its own parameters, and its name makes its default message."""

from typing import Any, get_args

import pytest
from pydantic import TypeAdapter, ValidationError

from voa_core.rules.registry import RULES
from voa_msgs.updates import BUILT_IN, POLICY_FIELDS, BuiltInUpdate, PluginUpdate, UpdateRule, default_update

UPDATE: TypeAdapter[Any] = TypeAdapter(UpdateRule)


def test_the_messages_are_those_of_the_rules_of_the_mathematics() -> None:
    assert list(BUILT_IN) == list(RULES)
    assert set(BUILT_IN.values()) == set(get_args(BuiltInUpdate))


@pytest.mark.parametrize("name", BUILT_IN)
def test_a_rule_is_read_by_its_name_with_parameters_that_are_null(name: str) -> None:
    update = UPDATE.validate_python({"rule": name})
    assert type(update) is BUILT_IN[name]
    parameters = update.model_dump(exclude=set(POLICY_FIELDS))
    assert set(parameters.values()) == {None}, "null: the service fills in the default"


@pytest.mark.parametrize(
    "wrong",
    [
        {"rule": "margin", "sigma_m": 1.0},
        {"rule": "gaussian", "margin_m": 0.008},
        {"rule": "beam", "temper": 0.0},
        {"rule": "beam", "temper": 1.5},
        {"rule": "margin", "score_floor": 0.6},
        {"rule": "margin", "no_return_m": 0.0},
        {"rule": "margin", "on_no_match": "ignore"},
        {"rule": "plugin"},
        {"rule": "other"},
    ],
)
def test_a_parameter_of_another_rule_or_beyond_its_bounds_is_refused(wrong: dict[str, Any]) -> None:
    with pytest.raises(ValidationError):
        UPDATE.validate_python(wrong)


def test_a_name_makes_the_message_of_its_rule() -> None:
    built_in = default_update("gaussian", no_return_m=2.0, on_no_match="nearest")
    assert type(built_in) is BUILT_IN["gaussian"]
    assert (built_in.no_return_m, built_in.on_no_match) == (2.0, "nearest")
    plugin = default_update("own", on_no_match="nearest")
    assert plugin == PluginUpdate(rule="plugin", name="own", parameters={}, on_no_match="nearest")
