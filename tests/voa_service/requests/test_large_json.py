"""Large messages to JSON and back: the same as in one step."""

import json

from hypothesis import given
from hypothesis import strategies as st

from tests.support.serving import data_scenario, json_of
from voa_msgs.scenarios import Scenario, ScenarioRequest
from voa_service.requests.large_json import blocks, dumped, loads, plain, text

LEAVES = st.none() | st.booleans() | st.integers() | st.floats(allow_nan=False, allow_infinity=False) | st.text()
VALUES = st.recursive(LEAVES, lambda inner: st.lists(inner) | st.dictionaries(st.text(), inner), max_leaves=30)


@given(VALUES)
def test_what_is_written_in_pieces_is_what_is_written_at_once(value: object) -> None:
    assert text(value) == json.dumps(value, sort_keys=True, separators=(",", ":"))
    assert loads(text(value)) == value


def test_long_lists_are_written_in_pieces_without_a_seam() -> None:
    value = {"a": [0.5] * 25_000, "b": [[1] * 10_000, [], [2] * 10_001, {}]}
    assert text(value) == json.dumps(value, separators=(",", ":"))


def test_blocks_to_hash_are_large_enough_for_other_threads_to_wake_up_in_between() -> None:
    value = {"a": [[0.123456789] * 4_000] * 100, "b": "end"}
    made = list(blocks(value))
    assert b"".join(made).decode() == text(value)
    assert len(made) > 3
    assert all(len(block) >= 1_000_000 for block in made[:-1])


def test_a_scenario_is_the_same_in_steps() -> None:
    request = ScenarioRequest.model_validate_json(json_of(data_scenario(prior=[0.2, 0.3, 0.5])))
    assert plain(request) == request.model_dump(mode="json")
    body = request.model_dump() | {"id": "x", "created_at": "2026-01-01T00:00:00Z", "warnings": []}
    scenario = Scenario.model_validate_json(json_of(body))
    assert Scenario.model_validate_json(dumped(scenario)) == scenario
    assert dumped(request) == request.model_dump_json().encode()
