"""All that the evaluation of looks found, and the figures that follow from it."""

from collections.abc import Sequence
from dataclasses import asdict, dataclass
from typing import Any

from voa_client import Client
from voa_evaluation.asking import after_a_look
from voa_evaluation.calibration import Bin, calibration
from voa_evaluation.dropping import make_drop
from voa_evaluation.grasp_scores import GraspScores
from voa_evaluation.outcomes import Level, Outcome, levels, outcomes
from voa_evaluation.rows import Rows
from voa_evaluation.running import Bar, Bench, evaluate, scores_of, set_up
from voa_evaluation.sensitivity import Point, vary
from voa_evaluation.setting import Setting
from voa_evaluation.worth import Gain, Worth, gains, worths
from voa_fleet.world.objects import FleetObject
from voa_msgs.scenarios import Scenario

_SHOWN_RULE = "inverse_rmsd"


@dataclass(frozen=True, eq=False)
class Example:
    """One look in full: the belief before and after it.

    Attributes:
        pose: the true one.
        sensor: from where the look was.
        before, after: beliefs.
    """

    scenario: Scenario
    pose: str
    sensor: str
    before: list[float]
    after: list[float]


@dataclass(frozen=True, eq=False)
class Found:
    """What was found; figures are made from `rows` and `points` alone."""

    setting: Setting
    scores: tuple[GraspScores, ...]
    examples: tuple[Example, ...]
    rows: Rows
    points: tuple[Point, ...]
    attempts: int
    worths: list[Worth]
    gains: list[Gain]
    outcomes: list[Outcome]
    bins: list[Bin]
    levels: list[Level]

    def report(self) -> dict[str, Any]:
        """What `--json` prints."""
        return {
            "drops": self.setting.drops,
            "attempts_per_score": self.setting.attempts,
            "sensitivity_drops": self.setting.sensitivity_drops,
            "seed": self.setting.seed,
            "attempts": self.attempts,
            "looks": [asdict(worth) for worth in self.worths],
            "gains": [asdict(gain) for gain in self.gains],
            "policies": [asdict(outcome) for outcome in self.outcomes],
            "calibration": [asdict(found) for found in self.bins],
            "sensitivity": [asdict(level) for level in self.levels],
        }


def find(client: Client, things: Sequence[FleetObject], setting: Setting, bar: Bar) -> Found:
    """Run the whole evaluation of looks.

    Raises:
        VoaClientError: the service cannot be reached, or refuses.
        UnstableSimulation: the physics exploded.
    """
    benches = []
    for thing in things:
        total = setting.attempts * len(thing.poses) * len(thing.grasps)
        with bar(f"{thing.name}: grasp scores", total) as advance:
            scores = scores_of(thing, setting, advance)
        benches.append(set_up(client, thing, scores, setting))
    rows = evaluate(client, benches, setting, bar)
    points = vary(client, benches, setting, bar)
    return Found(
        setting=setting,
        scores=tuple(bench.scores for bench in benches),
        examples=tuple(_example(client, bench, rows, setting) for bench in benches),
        rows=rows,
        points=points,
        attempts=sum(bench.table.attempts for bench in benches),
        worths=worths(rows, setting.seed),
        gains=gains(rows, setting.seed),
        outcomes=outcomes(rows, setting.seed),
        bins=calibration(rows, setting.seed),
        levels=levels(points, setting.seed),
    )


def _example(client: Client, bench: Bench, rows: Rows, setting: Setting) -> Example:
    """The look that VOA chose at the first drop with a uniform belief; the first place where it chose none."""
    row = rows.of(thing=bench.thing.name, kind="uniform", rule=_SHOWN_RULE).rows[0]
    name = row.chosen["voa"] or row.looks[0].sensor or ""
    sensor = next(sensor for sensor in bench.thing.scenario.sensors if sensor.name == name)
    drop = make_drop(bench.thing, "uniform", row.drop, setting.flaws, setting.seed)
    scenario = bench.asked.scenarios[_SHOWN_RULE]
    scan = bench.table.scan(drop, sensor, setting.flaws)
    after = after_a_look(client, scenario, drop.belief, sensor, scan)
    return Example(scenario, drop.pose, name, list(drop.belief), after.belief)
