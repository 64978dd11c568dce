"""Update rules in messages and in the mathematics: the same names and the same parameters."""

from typing import get_args

import pytest

from tests.voa_core.worlds import lidar_of
from voa_core.rules.registry import RULES, defaults
from voa_msgs.updates import BUILT_IN, PAPER_RULES, POLICY_FIELDS, BuiltInUpdate, PluginUpdate, default_update


def test_messages_and_mathematics_list_the_same_rules_in_the_same_order() -> None:
    assert list(BUILT_IN) == list(RULES)
    assert list(BUILT_IN.values()) == list(get_args(BuiltInUpdate))
    assert PAPER_RULES == ("margin", "exponential", "gaussian", "inverse_rmsd")


@pytest.mark.parametrize("name", list(BUILT_IN))
def test_a_message_has_the_parameters_of_its_rule(name: str) -> None:
    fields = BUILT_IN[name].model_fields
    assert get_args(fields["rule"].annotation) == (name,)
    assert set(fields) - POLICY_FIELDS == set(defaults(name, lidar_of(4)))
    assert all(fields[parameter].default is None for parameter in defaults(name, lidar_of(4)))


def test_an_update_is_made_by_name() -> None:
    assert [default_update(name).rule for name in RULES] == list(RULES)
    margin = default_update("margin", 1.0, "nearest")
    assert (margin.no_return_m, margin.on_no_match) == (1.0, "nearest")
    assert default_update("own", 1.0) == PluginUpdate(rule="plugin", name="own", no_return_m=1.0)
