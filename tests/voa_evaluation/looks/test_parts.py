"""Drops, scans, policies, calibration and the page, each on its own."""

import math
from dataclasses import replace

import numpy as np
import pytest

from voa_evaluation.looks.calibration import calibration
from voa_evaluation.looks.choices import choices
from voa_evaluation.looks.findings import Finding
from voa_evaluation.looks.outcomes import Rate
from voa_evaluation.looks.requests import EstimateBefore, RegisteredObject
from voa_evaluation.looks.rows import EvaluatedLook, Row, Rows
from voa_evaluation.looks.sensitivity import disturbed, stated_at
from voa_evaluation.looks.setting import RULES, Setting, default_imperfections, update_of
from voa_evaluation.looks.trials import TrialBench, boxes, make_trial
from voa_evaluation.looks.worth import gains, worths
from voa_evaluation.report.findings_section import findings_section
from voa_evaluation.statistics import Interval
from voa_fleet.episodes.forecasts import Forecast
from voa_fleet.episodes.policies import POLICIES
from voa_fleet.show.page import page
from voa_fleet.world.objects import FleetObject
from voa_msgs.rankings import Look, Ranking
from voa_msgs.updates import InverseRmsdUpdate, MarginUpdate

RANKED = "ESE"
RANKING = Ranking(
    version=None,
    definition="posterior",
    method="exact",
    precision="float64",
    expected_score_before=0.4,
    best_grasp_before="TD0",
    ranking=[],
    recommendation=Look(action="look", sensor=RANKED, net_value=0.1),
)


def test_a_drop_depends_on_names_and_seed_alone(mug: FleetObject) -> None:
    imperfections = default_imperfections()
    drop = make_trial(mug, "hinted", 3, imperfections, 7)
    assert drop == make_trial(mug, "hinted", 3, imperfections, 7)
    assert drop != make_trial(mug, "hinted", 4, imperfections, 7)
    assert drop != make_trial(mug, "hinted", 3, imperfections, 8)
    assert math.fsum(drop.belief) == pytest.approx(1.0)
    assert make_trial(mug, "uniform", 3, imperfections, 7).belief == pytest.approx([1 / 6] * 6)


def test_poses_are_drawn_from_the_belief(mug: FleetObject) -> None:
    imperfections = default_imperfections()
    drops = [make_trial(mug, "hinted", index, imperfections, 0) for index in range(400)]
    held = np.array([drop.belief[mug.poses.index(drop.drop.pose)] for drop in drops])
    # A pose that is drawn from b has sum(b^2) of it on average.
    expected = np.array([sum(share**2 for share in drop.belief) for drop in drops])
    assert held.mean() == pytest.approx(expected.mean(), abs=0.04)


def test_scans_share_their_chance_between_levels(mug: FleetObject) -> None:
    imperfections = default_imperfections()
    drop, sensor = make_trial(mug, "uniform", 0, imperfections, 0), mug.scenario.sensors[0]
    subject = TrialBench(mug, 0)
    scan = subject.scan(drop, sensor, imperfections)
    assert scan == TrialBench(mug, 0).scan(drop, sensor, imperfections)
    assert scan == subject.scan(drop, sensor, disturbed("clutter", 0.0, drop, Setting()))
    assert scan != subject.scan(drop, sensor, disturbed("robot_xy", 2.0, drop, Setting()))
    noisy = subject.scan(drop, sensor, replace(imperfections, range_noise_m=0.004))
    lost = [value == 0.0 for value in scan.ranges]
    assert lost == [value == 0.0 for value in noisy.ranges]


def test_fewer_boxes_are_the_first_of_more(mug: FleetObject) -> None:
    drop = make_trial(mug, "uniform", 0, default_imperfections(), 0)
    assert boxes(drop, 4, 0)[:2] == boxes(drop, 2, 0)
    assert all(0.13 <= math.hypot(*box.centre) <= 0.25 for box in boxes(drop, 4, 0))


def test_a_grasp_is_attempted_once_per_drop(mug: FleetObject) -> None:
    subject, drop = TrialBench(mug, 0), make_trial(mug, "uniform", 0, default_imperfections(), 0)
    assert subject.attempt(drop, "TD0") == subject.attempt(drop, "TD0")
    assert subject.attempts == 1
    assert subject.attempt(drop, "TD0") == TrialBench(mug, 0).attempt(drop, "TD0")


def test_what_is_stated_is_what_goes_wrong(mug: FleetObject) -> None:
    drop = make_trial(mug, "uniform", 0, default_imperfections(), 0)
    assert disturbed("robot_xy", 3.0, drop, Setting()).robot_xy_m == stated_at("robot_xy", 3.0).xy_m == 0.03
    assert disturbed("robot_yaw", 3.0, drop, Setting()).robot_yaw_rad == stated_at("robot_yaw", 3.0).yaw_rad
    assert disturbed("range_noise", 10.0, drop, Setting()).range_noise_m == 0.01


def test_rules_keep_the_scenarios_no_return() -> None:
    own = InverseRmsdUpdate(rule="inverse_rmsd", no_return_m=0.47, floor_m=0.002)
    made = [update_of(rule, own) for rule in RULES]
    assert [update.rule for update in made] == list(RULES)
    assert {update.no_return_m for update in made} == {0.47}
    assert own in made
    assert isinstance(made[0], MarginUpdate)
    assert made[0].on_no_match == "nearest"


def test_expected_entropy() -> None:
    clear, silent = np.eye(2), np.full((2, 2), 0.5)
    found = Forecast(np.zeros((2, 2)), np.array([clear, silent])).expected_entropies([0.5, 0.5])
    assert found == pytest.approx([0.0, math.log(2.0)])
    assert Forecast(np.zeros((1, 2)), np.array([silent])).expected_entropies([1.0, 0.0]) == pytest.approx([0.0])


def test_policies_choose_what_they_say(mug: FleetObject) -> None:
    class Stored:
        sensors = mug.scenario.sensors

    count, poses = len(mug.scenario.sensors), len(mug.poses)
    likelihoods = np.full((count, poses, poses), 1.0 / poses)
    likelihoods[4] = np.eye(poses)
    visible = np.ones((count, poses))
    visible[6] = 5.0
    forecasts = {"beam": Forecast(visible, likelihoods)}
    registered = RegisteredObject({"beam": Stored()}, forecasts)  # type: ignore[dict-item]  # only sensors are read
    trial = make_trial(mug, "uniform", 0, default_imperfections(), 0)
    trial = replace(trial, bearing_rad=math.radians(155.0), random_look=2)
    before = EstimateBefore(RANKING, "TD0", 0.4, (0.0,) * count)
    assert before.look == RANKED
    chosen = choices(list(POLICIES), registered, "beam", trial, before)
    assert chosen == {
        "voa": RANKED,
        "entropy": "WSW",
        "beams": "SSE",
        "nearest": "WNW",
        "random": "NNW",
        "none": None,
    }


def _row(index: int, voa: tuple[float, ...], lifted: tuple[bool, ...], without: bool) -> Row:
    def look(sensor: str | None, worth: float, success: bool) -> EvaluatedLook:
        return EvaluatedLook(sensor, worth, 0.4 + worth, "", 0.5, "G", "lifted" if success else "slipped")

    looks = tuple(look(f"Q{place}", worth, ok) for place, (worth, ok) in enumerate(zip(voa, lifted, strict=True)))
    chosen: dict[str, str | None] = {**dict.fromkeys(POLICIES, "Q0"), "voa": "Q1", "none": None}
    return Row("target", "uniform", index, "P", "beam", look(None, 0.0, without), looks, chosen)


def test_worth_and_gain_from_rows() -> None:
    rows = Rows(
        (
            _row(0, (0.05, 0.25), (False, True), without=False),
            _row(1, (0.05, 0.25), (True, True), without=True),
            _row(2, (0.05, 0.25), (False, True), without=False),
            _row(3, (0.05, 0.25), (False, False), without=True),
        )
    )
    first, second = worths(rows, 0)
    assert (first.achieved.value, second.achieved.value) == (-0.25, 0.25)
    assert (second.with_look, second.without, second.achieved.count) == (3, 2, 4)
    assert second.aecd.value == pytest.approx(0.25)
    (gain,) = gains(rows, 0)
    assert (gain.delta.value, gain.best, gain.delta_star.value, gain.over_random.value) == (0.25, "Q1", 0.25, 0.25)
    assert gain.tau is not None
    assert gain.tau.value == 1.0
    low, high = calibration(rows, 0)
    assert (low.voa, low.achieved.value, low.achieved.count) == pytest.approx((0.05, -0.25, 4))
    assert (high.voa, high.achieved.value, high.drops) == pytest.approx((0.25, 0.25, 4))


def test_negative_findings_stand_in_a_table_with_their_reason_in_a_column_of_its_own() -> None:
    interval = Interval(0.25, 0.1, 0.75, 4)
    better = Finding("uniform", "beam", "random", "better", Rate(3, 4), Rate(2, 4), interval)
    neither = replace(
        better, rule="margin", verdict="no difference shown", seen="In 1 of 4 drops.", reason="Few drops."
    )
    html = page("t", (), [findings_section([better, neither])])
    _, good, worse, equal = html.split("<h3>")
    assert "<td>beam</td><td>uniform</td><td>random</td>" in good
    assert '<td class="number">+0.250 [+0.100, +0.750]</td>' in good
    assert "reason" not in good
    assert "<p>Nowhere.</p>" in worse
    assert "<th>reason</th>" in equal
    assert ">Few drops.</td>" in equal
    assert ">In 1 of 4 drops.</td>" in equal
    assert "1 favour VOA" in html
