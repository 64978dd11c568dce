"""The live report: lines of events, and the table that is kept up to date."""

import io
import re
from datetime import UTC, datetime

import pytest
from rich.console import Console
from rich.table import Table

from voa_fleet.devices.protocol import GraspOutcome
from voa_fleet.episodes.events import (
    Event,
    GraspEnded,
    GraspStarted,
    LookChosen,
    LookTaken,
    OutcomeReported,
    SessionOpened,
    Step,
)
from voa_fleet.episodes.looks import EpisodeLook
from voa_fleet.show.event_lines import event_line
from voa_fleet.show.live_report import LiveReport
from voa_fleet.show.tables import PairState, belief_table
from voa_msgs.rankings import GraspNow, Look, RankedSensor, Ranking
from voa_msgs.sessions import Session, UpdatedSession, UpdateReport

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
            ties_with_first=voa == 0.25,
        )
        for name, voa in (("Q1", 0.25), ("Q2", -0.01))
    ],
    recommendation=Look(action="look", sensor="Q1", net_value=0.25),
)
FIRST, SECOND = RANKING.ranking
TIE = RANKING.model_copy(update={"ranking": [FIRST, FIRST.model_copy(update={"sensor": "Q2"}), SECOND]})
LITTLE = RANKING.model_copy(update={"ranking": [FIRST.model_copy(update={"net_value": 0.0004}), SECOND]})
REPORT = UpdateReport(
    accepted=True,
    reason=None,
    log_evidence=-1.0,
    fit_rmsd_mm=3.0,
    fit_hit_rmsd_mm=4.0,
    best_fit_pose="P1",
    beams_compared=9,
)


CLOSE = TIE.model_copy(
    update={"ranking": [FIRST, FIRST.model_copy(update={"sensor": "Q2", "net_value": 0.24}), SECOND]}
)
PAIR = RANKING.model_copy(update={"recommendation": Look(action="look", sensor="Q1", net_value=0.34, then="Q2")})
GRASP = RANKING.model_copy(update={"recommendation": GraspNow(action="grasp", grasp="G1", expected_score=0.5)})


def reported(*, accepted: bool) -> UpdatedSession:
    """The session after an outcome."""
    update = REPORT.model_copy(update={"accepted": accepted, "reason": None if accepted else "no_match"})
    return UpdatedSession(**dict(session([0.9, 0.1])), update=update)


def session(belief: list[float], absent: float | None = None) -> Session:
    return Session(
        absent=absent,
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


def looked(report: UpdateReport | None) -> LookTaken:
    return LookTaken(EpisodeLook("Q1", None, session([0.9, 0.1]), report))


@pytest.mark.parametrize(
    ("step", "line"),
    [
        (SessionOpened(session([0.5, 0.5])), "session abc: 2 poses, all 0.50; best grasp G1, 0.50"),
        (LookChosen("Q1", RANKING, 0.005), "look from Q1 next (Q1 is worth +0.250, Q2 -0.010)"),
        (LookChosen("Q1", TIE, 0.005), "look from Q1 next (Q1 is worth +0.250, Q2 as much, Q2 -0.010)"),
        (LookChosen("Q2", None, 0.005), "look from Q2 next"),
        (LookChosen(None, RANKING, 0.005, used_up=True), "the looks are used up (Q1 is worth +0.250): grasp"),
        (LookChosen(None, LITTLE, 0.005), "no look's net value is more than min_gain 0.005 (Q1: < 0.001): grasp"),
        (LookChosen(None, None, 0.005), "no more looks: grasp"),
        (LookChosen(None, None, 0.005, used_up=True), "the looks are used up: grasp"),
        (looked(REPORT), "looked from Q1: best fit 4.0 mm; P1 0.90, P2 0.10; best grasp G1, 0.50"),
        (looked(None), "looked from Q1: not accepted; P1 0.90, P2 0.10; best grasp G1, 0.50"),
        (
            looked(REPORT.model_copy(update={"accepted": False, "reason": "no_match"})),
            "looked from Q1: not accepted (no_match); P1 0.90, P2 0.10; best grasp G1, 0.50",
        ),
        (GraspStarted("G1", 0.5), "the arm tries G1, expected to succeed with 0.50"),
        (GraspStarted(None, 0.0), "no grasp within reach is expected to succeed: the arm stays where it is"),
        (GraspEnded(GraspOutcome("G1", success=True, detail="lifted")), "G1 succeeded: lifted"),
        (GraspEnded(GraspOutcome("G1", success=False)), "G1 FAILED"),
        (OutcomeReported(reported(accepted=True)), "outcome reported: the belief has changed"),
        (OutcomeReported(reported(accepted=False)), "outcome reported: the belief stays unchanged"),
        (
            OutcomeReported(reported(accepted=True), moved=True),
            "outcome reported: the attempt has moved the object, and the belief is the prior again",
        ),
        (
            SessionOpened(session([0.9, 0.1], absent=0.03)),
            "session abc: P1 0.90, P2 0.10; best grasp G1, 0.50; absent 0.03",
        ),
        (LookChosen("Q1", PAIR, 0.005), "look from Q1 next, then from Q2 (worth +0.340 together)"),
        (LookChosen("Q2", PAIR, 0.005), "look from Q2 next, the second of the pair (worth -0.010)"),
        (LookChosen("Q2", GRASP, 0.005), "look from Q2 next, the second of the pair (worth -0.010)"),
        (LookChosen("Q1", CLOSE, 0.005), "look from Q1 next (Q1 is worth +0.250, Q2 +0.240 (ties), Q2 -0.010)"),
    ],
)
def test_each_event_is_a_line(step: Step, line: str) -> None:
    assert event_line(step) == line


def shown(table: Table, width: int = 80) -> list[str]:
    out = io.StringIO()
    Console(file=out, width=width, color_system=None).print(table)
    return out.getvalue().splitlines()


def of_many(poses: int, looks: int, best: int) -> PairState:
    belief = [0.5 / (poses - 1)] * poses
    belief[best] = 0.5
    many = session(belief).model_copy(update={"poses": [f"P_{index}" for index in range(poses)]})
    ranked = [
        SECOND.model_copy(update={"sensor": f"Q_{index}", "voa": 0.01, "net_value": 0.01}) for index in range(looks)
    ]
    return PairState("one", many, RANKING.model_copy(update={"ranking": [FIRST, *ranked[1:]]}))


@pytest.mark.parametrize("lines", [5, 12, 18])
def test_many_poses_fit_the_screen_with_the_likeliest_first_and_the_others_summed_up(lines: int) -> None:
    table = shown(belief_table(of_many(24, 30, best=20), lines))
    assert len(table) == lines + 5  # a title and the frame
    assert max(map(len, table)) <= 80
    assert "P_20" in table[4]
    assert "0.50" in table[4]
    assert f"{24 - (lines - 1)} others" in table[-2]
    assert f"{30 - (lines - 1)} others" in table[-2]
    assert f"{0.5 * (24 - (lines - 1)) / 23:.2f}" in table[-2]


def test_poses_that_fit_are_all_there_as_listed() -> None:
    table = shown(belief_table(of_many(24, 8, best=20), 24))
    assert [line.split()[1] for line in table[4:-1]] == [f"P_{index}" for index in range(24)]


def test_bars_state_their_scale_and_ties_their_rank() -> None:
    table = "\n".join(shown(belief_table(PairState("one", session([0.998, 0.002]), TIE))))
    assert "0 to 1" in table
    assert "0 to 0.25" in table
    assert table.count("=1") == 2
    assert "< 0.01" in table


def test_the_live_table_is_never_higher_than_the_screen() -> None:
    out = io.StringIO()
    console = Console(file=out, force_terminal=True, width=100, height=16, color_system=None)
    with LiveReport(console, ("one",)) as report:
        many = of_many(24, 8, best=3).session
        assert many is not None
        report(Event("one", 0.0, SessionOpened(many)))
    last = out.getvalue().split("one, 0 s")[-1]
    assert "15 others" in last
    assert len(last.splitlines()) <= 16


def test_on_a_narrow_terminal_lines_are_broken_between_words_and_indented() -> None:
    out = io.StringIO()
    with LiveReport(Console(file=out, force_terminal=True, width=40, color_system=None), ("one",)) as report:
        report(Event("one", 4.0, looked(REPORT)))
    plain = re.sub(r"\x1b\[[0-9;?]*[A-Za-z]", "", out.getvalue())
    lines = [line.rstrip() for line in plain.splitlines()]
    start = next(index for index, line in enumerate(lines) if "looked from Q1" in line)
    assert lines[start : start + 3] == [
        "   4.0 s  looked from Q1: best fit 4.0",
        "          mm; P1 0.90, P2 0.10; best",
        "          grasp G1, 0.50",
    ]


def test_names_are_printed_as_they_are() -> None:
    odd = session([0.6, 0.4]).model_copy(update={"poses": ["[red]", "[/x]"], "best_grasp": "[top]"})
    out = io.StringIO()
    with LiveReport(Console(file=out, force_terminal=True, width=160, color_system=None), ("one", "two")) as report:
        for pair in ("one", "two"):
            report(Event(pair, 0.0, SessionOpened(odd)))
    assert "[red] 0.60, [/x] 0.40; best grasp [top]" in out.getvalue()
    assert "[red]" in "\n".join(shown(belief_table(report.states[0])))


def printed(pairs: tuple[str, ...], *, terminal: bool) -> str:
    out = io.StringIO()
    console = Console(file=out, force_terminal=terminal, width=160, color_system=None)
    with LiveReport(console, pairs) as report:
        for pair in pairs:
            report(Event(pair, 0.0, SessionOpened(session([0.5, 0.5]))))
            report(Event(pair, 0.0, LookChosen("Q1", RANKING, 0.005)))
            report(Event(pair, 4.0, looked(REPORT)))
            report(Event(pair, 5.0, GraspEnded(GraspOutcome("G1", success=pair == "one"))))
    assert [state.looks for state in report.states] == [("Q1",)] * len(pairs)
    assert [state.success for state in report.states] == [pair == "one" for pair in pairs]
    return out.getvalue()


def test_in_a_pipe_there_are_lines_alone() -> None:
    said = printed(("one",), terminal=False)
    assert len(said.splitlines()) == 4
    assert "look from Q1 next" in said


def test_on_a_terminal_belief_and_ranking_follow() -> None:
    said = printed(("one",), terminal=True)
    assert "belief" in said
    assert "0 to 0.25" in said
    assert "0.90" in said


def test_several_pairs_have_a_row_each() -> None:
    said = printed(("one", "two"), terminal=True)
    assert "lifted" in said
    assert "failed" in said
