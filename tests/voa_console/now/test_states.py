"""State of a session in words."""

import pytest

from tests.voa_console.now.test_summary import NOW, session
from voa_client import HistoryEntry, SessionSummary
from voa_console.now.states import state_of

TOP = {"grasp": "TOP", "success": True}
LOOKED = [{"sensor": "N", "sensor_pose": None, "looks": 2}, {"sensor": "E", "sensor_pose": None, "looks": 1}]
UNDER_WAY = {"sensor": "N", "sensor_pose": None, "robot": None, "id": "a", "expires_at": NOW}


def entry(kind: str, request: object, version: int = 4) -> HistoryEntry:
    return HistoryEntry.model_validate(
        {"version": version, "kind": kind, "at": NOW, "request": request, "update": None}
    )


@pytest.mark.parametrize(
    ("places", "newest", "text"),
    [
        ([], None, "Waits for a look"),
        (LOOKED, None, "Looked 3 times"),
        (LOOKED[1:], None, "Looked once"),
        (LOOKED, entry("outcome", TOP), "Looked 3 times; TOP succeeded"),
        (LOOKED, entry("outcome", TOP | {"success": False}), "Looked 3 times; TOP failed"),
        (LOOKED, entry("outcome", TOP, version=3), "Looked 3 times"),
        (LOOKED, entry("scan", {}), "Looked 3 times"),
        ([], entry("outcome", TOP), "TOP succeeded"),
        ([], entry("belief", {"belief": None}), "Belief reset to the prior; waits for a look"),
        ([], entry("belief", {"belief": [1.0]}), "Belief replaced; waits for a look"),
    ],
)
def test_a_state(places: list[dict[str, object]], newest: HistoryEntry | None, text: str) -> None:
    assert state_of(session([1.0], version=4, places=places), newest) == text


@pytest.mark.parametrize(("version", "text"), [(0, "Waits for a look"), (2, "Changed twice"), (3, "Changed 3 times")])
def test_of_a_summary_the_number_of_versions_is_all_that_is_known(version: int, text: str) -> None:
    fields = session([1.0], version=version).model_dump()
    listed = SessionSummary(**{name: fields[name] for name in SessionSummary.model_fields})
    assert state_of(listed, None) == text


@pytest.mark.parametrize(("number", "text"), [(1, "A look is under way"), (2, "2 looks are under way")])
def test_looks_that_are_under_way_are_counted(number: int, text: str) -> None:
    assert state_of(session([1.0], under_way=[UNDER_WAY] * number), None) == text
