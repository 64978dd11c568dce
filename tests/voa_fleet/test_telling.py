"""Telling: lines, and the table that follows."""

import io
from datetime import UTC, datetime

import pytest
from rich.console import Console

from voa_fleet.devices import GraspOutcome
from voa_fleet.story import Chosen, Event, Grasped, Grasping, Happening, Looked, Opened, Reported, TakenLook
from voa_fleet.telling import Teller, line_of
from voa_msgs.rankings import Look, RankedSensor, Ranking
from voa_msgs.sessions import Session, UpdateReport

NOW = datetime(2026, 1, 1, tzinfo=UTC)
RANKING = Ranking(
    version=0,
    definition="posterior",
    method="exact",
    precision="float64",
    expected_score_before=0.5,
    best_grasp_before="G1",
    ranking=[
        RankedSensor(
            sensor=name,
            voa=voa,
            standard_error=None,
            cost=0.0,
            net_value=voa,
            expected_score_after=0.5 + voa,
            ties_with_first=False,
        )
        for name, voa in (("Q1", 0.25), ("Q2", -0.01))
    ],
    recommendation=Look(action="look", sensor="Q1", net_value=0.25),
)
REPORT = UpdateReport(
    accepted=True,
    reason=None,
    log_evidence=-1.0,
    fit_rmsd_mm=3.0,
    fit_hit_rmsd_mm=4.0,
    best_fit_pose="P1",
    beams_compared=9,
)


def session(belief: list[float]) -> Session:
    return Session(
        scenario="s",
        version=1,
        poses=["P1", "P2"],
        belief=belief,
        best_grasp="G1",
        expected_score=0.5,
        entropy_nats=0.1,
        last_fit_rmsd_mm=None,
        id="abc",
        created_at=NOW,
        updated_at=NOW,
    )


def looked(report: UpdateReport | None) -> Looked:
    return Looked(TakenLook("Q1", None, session([0.9, 0.1]), report))


@pytest.mark.parametrize(
    ("what", "line"),
    [
        (Opened(session([0.5, 0.5])), "session abc: 2 poses, all 0.50; best grasp G1, 0.50"),
        (Chosen("Q1", RANKING), "look from Q1 next (Q1 is worth +0.250, Q2 -0.010)"),
        (Chosen("Q2", None), "look from Q2 next"),
        (Chosen(None, RANKING, used_up=True), "the looks are used up (Q1 is worth +0.250): grasp"),
        (Chosen(None, None), "no more looks: grasp"),
        (looked(REPORT), "looked from Q1: best fit 4.0 mm; P1 0.90, P2 0.10; best grasp G1, 0.50"),
        (looked(None), "looked from Q1: not accepted; P1 0.90, P2 0.10; best grasp G1, 0.50"),
        (
            looked(REPORT.model_copy(update={"accepted": False, "reason": "no_match"})),
            "looked from Q1: not accepted (no_match); P1 0.90, P2 0.10; best grasp G1, 0.50",
        ),
        (Grasping("G1", 0.5), "the arm tries G1, expected to succeed with 0.50"),
        (Grasping(None, 0.0), "no grasp within reach is expected to succeed: the arm stays where it is"),
        (Grasped(GraspOutcome("G1", success=True, detail="lifted")), "G1 succeeded: lifted"),
        (Grasped(GraspOutcome("G1", success=False)), "G1 FAILED"),
        (Reported(None), "not reported: the attempt has moved the object, and the belief is about where it was"),
    ],
)
def test_each_event_is_a_line(what: Happening, line: str) -> None:
    assert line_of(what) == line


def told(pairs: tuple[str, ...], *, terminal: bool) -> str:
    out = io.StringIO()
    console = Console(file=out, force_terminal=terminal, width=160, color_system=None)
    with Teller(console, pairs) as teller:
        for pair in pairs:
            teller(Event(pair, 0.0, Opened(session([0.5, 0.5]))))
            teller(Event(pair, 0.0, Chosen("Q1", RANKING)))
            teller(Event(pair, 4.0, looked(REPORT)))
            teller(Event(pair, 5.0, Grasped(GraspOutcome("G1", success=pair == "one"))))
    assert [row.looks for row in teller.rows] == [("Q1",)] * len(pairs)
    assert [row.success for row in teller.rows] == [pair == "one" for pair in pairs]
    return out.getvalue()


def test_in_a_pipe_there_are_lines_alone() -> None:
    said = told(("one",), terminal=False)
    assert len(said.splitlines()) == 4
    assert "look from Q1 next" in said


def test_on_a_terminal_belief_and_ranking_follow() -> None:
    said = told(("one",), terminal=True)
    assert "belief" in said
    assert "worth" in said
    assert "0.90" in said


def test_several_pairs_have_a_row_each() -> None:
    said = told(("one", "two"), terminal=True)
    assert "lifted" in said
    assert "failed" in said
