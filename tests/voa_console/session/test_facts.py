"""Facts of a moment, and the view of its scene."""

import json

from tests.voa_console.session.test_heat_map import scenario
from tests.voa_console.session.test_moments import AT, HISTORY, SESSION
from tests.voa_console.session.test_words import ranking, row
from voa_console.session.facts import Facts, newest_scan, robot_place, scan_request, taken_scan, view_of
from voa_console.session.moments import moment_at
from voa_msgs.robots import LookReport, RobotReport
from voa_msgs.scenarios import Predictions
from voa_msgs.sessions import HistoryEntry

RANKING = ranking({"action": "look", "sensor": "E", "net_value": 0.1}, row("E", 0.1, ties=True)).model_copy(
    update={"version": 2}
)
SCAN = {"sensor": "E", "scan": {"ranges": [0.5, None], "no_return": [1]}}


def robot(sensor: str | None) -> RobotReport:
    look = LookReport(at=AT, sensor=sensor, sensor_pose=None, accepted=True, reason=None, version=2)
    return RobotReport(
        robot="tb3_1",
        session="s",
        source="ros2",
        key="k",
        last_scan_at=AT,
        scans=1,
        looks=1,
        refused=0,
        last_refusal=None,
        waiting_for=None,
        last_look=look if sensor else None,
    )


def facts(version: int | None) -> Facts:
    moment = moment_at(version, SESSION, HISTORY)
    return Facts(scenario(), SESSION, moment, HISTORY, RANKING, robots=(robot("E"),))


def test_now_has_the_ranking_and_the_robots() -> None:
    view = view_of(facts(None))
    assert view.ranking is RANKING
    assert [(each.name, each.place.x) for each in view.robots] == [("tb3_1", 0.3)]
    assert list(view.belief) == [0.9, 0.1]


def test_the_past_has_its_belief_and_no_ranking_or_robots() -> None:
    view = view_of(facts(1))
    assert (view.ranking, list(view.robots), list(view.belief), view.best_grasp) == (None, [], [0.6, 0.4], "G2")


def test_a_ranking_of_an_older_version_is_not_shown_as_the_present_one() -> None:
    old = Facts(
        scenario(), SESSION, moment_at(None, SESSION, HISTORY), ranking=RANKING.model_copy(update={"version": 1})
    )
    assert view_of(old).ranking is None


def test_robots_without_a_look_have_no_place() -> None:
    assert robot_place(robot(None), scenario()) is None
    assert robot_place(robot("elsewhere"), scenario()) is None


def test_the_newest_scan_up_to_a_version_is_read_from_the_history() -> None:
    entries = [
        HistoryEntry.model_validate({"version": number, "kind": kind, "at": AT, "request": request, "update": None})
        for number, kind, request in ((0, "prior", {}), (1, "scan", SCAN), (2, "outcome", {}), (3, "scan", {}))
    ]
    entry = newest_scan(entries, 2)
    assert entry is entries[1]
    assert newest_scan(entries, 0) is None
    assert scan_request(entry).scan.no_return == [1]


def test_a_taken_scan_has_the_outline_of_the_likeliest_pose() -> None:
    request = scan_request(
        HistoryEntry.model_validate_json(
            json.dumps({"version": 1, "kind": "scan", "at": AT.isoformat(), "request": SCAN, "update": None})
        )
    )
    predictions = Predictions(sensors=["E"], poses=["A", "B"], ranges=[[[0.1, 0.2], [0.3, None]]])
    taken = taken_scan(request, scenario(), [0.2, 0.8], predictions)
    assert taken is not None
    assert (taken.place.x, list(taken.predicted)) == (0.3, [0.3, None])
    assert taken_scan(request.model_copy(update={"sensor": "gone"}), scenario(), [0.2, 0.8], None) is None
