"""`voa replay DIR`: a recorded experiment through the service.

For every update rule and sensor configuration: the Value of Assistance beforehand, what the look was worth with
the scans that were really measured (AECD), and how far measurement and prediction are apart.
"""

import argparse
import json
import math
import sys
from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import Any, Literal

from rich.console import Console
from rich.progress import Progress
from rich.table import Table

from voa_cli.local_service import service_at
from voa_client import Client, VoaClientError
from voa_client.recorded import InvalidExperiment, RecordedExperiment, read_experiment
from voa_client.session_file import read_session_file, replay_session
from voa_msgs.geometry import CandidateSensor, SensorConfiguration
from voa_msgs.lidars import Lidar
from voa_msgs.rankings import RankingRequest
from voa_msgs.scenarios import GivenScores, Grasp, MeasuredScores, Pose, PredictionsRequest, ScenarioRequest
from voa_msgs.sessions import Scan, UpdateRequest
from voa_msgs.updates import (
    BeamUpdate,
    ExponentialUpdate,
    GaussianUpdate,
    InverseRmsdUpdate,
    MarginUpdate,
    UpdateRule,
)

Source = Literal["recorded", "mesh"]
Ranges = list[float | None]
Predictions = dict[str, dict[str, Ranges]]

RULES = ("margin", "exponential", "gaussian", "inverse_rmsd")
_LONGEST_NAME = 100
_AGREES = 1e-6


def main(arguments: Sequence[str] | None = None) -> int:
    """Replay, print, and return 0; 1 if something is wrong or the expected numbers do not come out."""
    options = _parser().parse_args(arguments)
    to_terminal = Console()
    if options.folder.is_file():
        return _replay_session(options, to_terminal)
    try:
        experiment = read_experiment(options.folder)
        with service_at(options.url) as client, Progress(console=Console(stderr=True), transient=True) as progress:
            report = replay(client, experiment, options.predict, options.rules, progress)
    except VoaClientError as error:
        print(f"voa replay: {error}", file=sys.stderr)
        return 1
    if options.json:
        json.dump(report, sys.stdout, indent=1)
        print()
        return 0
    _print(to_terminal, report)
    if experiment.expected is None or options.predict != "recorded":
        return 0
    apart = distance_from_expected(report, experiment.expected, experiment.pose_names)
    agrees = apart <= _AGREES
    to_terminal.print(f"expected.json: {'agrees' if agrees else 'DISAGREES'}, largest difference {apart:.1e}")
    return 0 if agrees else 1


def _replay_session(options: argparse.Namespace, console: Console) -> int:
    try:
        with service_at(options.url) as client:
            done = replay_session(client, read_session_file(options.folder), options.mesh)
    except VoaClientError as error:
        print(f"voa replay: {error}", file=sys.stderr)
        return 1
    if options.json:
        print(done.session.model_dump_json(indent=1))
    else:
        told = "exactly what the first one did" if done.same else "something ELSE than the first one did"
        console.print(f"session {done.session.id}, version {done.session.version}: believes {told}", highlight=False)
    return 0 if done.same else 1


def replay(
    client: Client, experiment: RecordedExperiment, source: Source, rules: Sequence[str], progress: Progress
) -> dict[str, Any]:
    """The report of `voa replay --json`.

    Raises:
        InvalidExperiment: predictions from the mesh are wanted, and something that they need is missing.
        VoaClientError: the service cannot be reached, or refuses.
    """
    recorded = {
        sensor.name: {pose: experiment.predicted_ranges(sensor.name, pose) for pose in experiment.pose_names}
        for sensor in experiment.sensors
    }
    predictions = recorded if source == "recorded" else predict_from_mesh(client, experiment)
    found: dict[str, dict[str, Any]] = {}
    before: dict[str, Any] = {}
    task = progress.add_task("replaying", total=len(rules) * len(experiment.sensors))
    for rule in rules:
        scenario = client.create_scenario(_scenario(experiment, _update(rule, experiment), predictions))
        belief = [1.0 / len(experiment.poses)] * len(experiment.poses)
        ranking = client.rank_once(RankingRequest(scenario=scenario.id, belief=belief))
        before = {"best_grasp": ranking.best_grasp_before, "expected_score": ranking.expected_score_before}
        voa = {look.sensor: look.voa for look in ranking.ranking}
        found[rule] = {}
        for sensor in experiment.sensors:
            worth = _executed(client, experiment, scenario.id, sensor.name, belief, ranking.expected_score_before)
            found[rule][sensor.name] = {"voa": voa[sensor.name]} | worth
            progress.advance(task)
    return {
        "experiment": experiment.name,
        "poses": experiment.pose_names,
        "sensors": [sensor.name for sensor in experiment.sensors],
        "before": before,
        "rules": found,
        "prediction": _errors(experiment, predictions, source),
    }


def _executed(
    client: Client, experiment: RecordedExperiment, scenario: str, sensor: str, belief: list[float], before: float
) -> dict[str, Any]:
    """What looking from `sensor` was worth: AECD, and the belief after each scan that was measured there."""
    beliefs, scores = {}, []
    for pose in experiment.pose_names:
        if not experiment.scan(sensor, pose).was_measured:
            continue
        ranges = experiment.measured_ranges(sensor, pose)
        nothing = [index for index, value in enumerate(ranges) if value is None]
        scan = Scan(ranges=ranges, no_return=nothing, range_min=0.0)
        after = client.update_once(UpdateRequest(scenario=scenario, belief=belief, sensor=sensor, scan=scan))
        beliefs[pose] = after.belief
        scores.append(after.expected_score)
    everywhere = len(scores) == len(belief)
    return {"aecd": math.fsum(scores) / len(scores) - before if everywhere else None, "beliefs": beliefs}


def predict_from_mesh(client: Client, experiment: RecordedExperiment) -> Predictions:
    """Predicted scans from the experiment's mesh, each pair at the plane height of its own scan."""
    if experiment.mesh is None:
        raise InvalidExperiment(f"{experiment.name} has no mesh to predict from")
    heights = {
        (sensor.name, pose): experiment.height_m(sensor.name, pose)
        for sensor in experiment.sensors
        for pose in experiment.pose_names
    }
    if None in heights.values() or any(pose.position is None for pose in experiment.poses):
        raise InvalidExperiment(
            f"{experiment.name}: predictions from the mesh need plane heights, and position and quaternion_wxyz "
            "of every pose"
        )
    mesh = client.create_object(experiment.mesh, experiment.name, experiment.scale)
    scenario = client.create_scenario(_scenario(experiment, MarginUpdate(rule="margin"), None, mesh.id))
    levels = sorted({height for height in heights.values() if height is not None})
    stands = [
        CandidateSensor(name=f"{index}@{level}", x=own.x, y=own.y, yaw_rad=own.yaw_rad, height_m=level)
        for index, own in enumerate(_sensors(experiment))
        for level in levels
    ]
    predicted = client.predict(scenario.id, PredictionsRequest(sensors=list(stands)))
    by_stand = dict(zip(predicted.sensors, predicted.ranges, strict=True))
    return {
        sensor.name: {
            pose: by_stand[f"{index}@{heights[sensor.name, pose]}"][row]
            for row, pose in enumerate(experiment.pose_names)
        }
        for index, sensor in enumerate(experiment.sensors)
    }


def _scenario(
    experiment: RecordedExperiment, update: UpdateRule, predictions: Predictions | None, mesh: str | None = None
) -> ScenarioRequest:
    recorded = experiment.lidar
    lidar = Lidar(
        beams=recorded.beams,
        angle_min=math.radians(recorded.angle_min_deg),
        angle_increment=math.radians(recorded.angle_increment_deg),
        range_min=recorded.range_min,
        range_max=max(recorded.range_max, experiment.no_return_m),
        zero="missing",
    )
    if experiment.scores is not None:
        scores: GivenScores | MeasuredScores = GivenScores(probabilities=experiment.scores)
    else:
        scores = MeasuredScores(attempts=experiment.attempts or 0, successes=experiment.successes or [])
    return ScenarioRequest(
        name=f"{experiment.name[:_LONGEST_NAME]}, {update.rule}",
        object=mesh,
        poses=[
            Pose(name=pose.name, position=pose.position, quaternion_wxyz=pose.quaternion_wxyz)
            if mesh is not None
            else Pose(name=pose.name)
            for pose in experiment.poses
        ],
        grasps=[Grasp(name=grasp) for grasp in experiment.grasps],
        scores=scores,
        sensors=_sensors(experiment),
        lidar=lidar,
        update=update,
        predictions=predictions,
    )


def _sensors(experiment: RecordedExperiment) -> list[SensorConfiguration]:
    first = experiment.pose_names[0]
    return [
        SensorConfiguration(
            name=sensor.name,
            x=sensor.x,
            y=sensor.y,
            yaw_rad=math.radians(sensor.yaw_deg),
            height_m=experiment.height_m(sensor.name, first),
        )
        for sensor in experiment.sensors
    ]


def _update(rule: str, experiment: RecordedExperiment) -> UpdateRule:
    no_return = experiment.no_return_m
    match rule:
        case "margin":
            return MarginUpdate(rule="margin", no_return_m=no_return, on_no_match="nearest")
        case "exponential":
            return ExponentialUpdate(rule="exponential", no_return_m=no_return)
        case "gaussian":
            return GaussianUpdate(rule="gaussian", no_return_m=no_return)
        case "inverse_rmsd":
            return InverseRmsdUpdate(rule="inverse_rmsd", no_return_m=no_return)
        case _:
            return BeamUpdate(rule="beam", no_return_m=no_return)


def _errors(experiment: RecordedExperiment, predictions: Predictions, source: Source) -> dict[str, Any]:
    """How far measured and predicted ranges are apart, over the rows that have both."""
    apart, from_recorded = [], []
    for (sensor, pose), scan in experiment.scans.items():
        predicted = predictions[sensor][pose]
        for beam in scan.beams:
            now = predicted[beam.index]
            if beam.measured is not None and now is not None:
                apart.append(1e3 * abs(beam.measured - now))
            if beam.predicted is not None:
                from_recorded.append(abs((experiment.no_return_m if now is None else now) - beam.predicted))
    against = {"beams": len(from_recorded), "max_abs_m": max(from_recorded)} if from_recorded else None
    apart.sort()
    return {
        "source": source,
        "beams": len(apart),
        "median_abs_mm": percentile(apart, 0.5),
        "p95_abs_mm": percentile(apart, 0.95),
        "max_abs_mm": percentile(apart, 1.0),
        "against_recorded": against if source == "mesh" else None,
    }


def percentile(ordered: Sequence[float], share: float) -> float | None:
    """The linear percentile of ascending numbers; None of none."""
    if not ordered:
        return None
    place = share * (len(ordered) - 1)
    below = math.floor(place)
    above = min(below + 1, len(ordered) - 1)
    return ordered[below] + (place - below) * (ordered[above] - ordered[below])


def distance_from_expected(report: dict[str, Any], expected: dict[str, Any], poses: Sequence[str]) -> float:
    """The largest difference between a report and an `expected.json`; infinite where they name other things."""
    if report["before"]["best_grasp"] != expected["before"]["best_grasp"]:
        return math.inf
    apart: list[float] = [abs(report["before"]["expected_score"] - expected["before"]["expected_score"])]
    for rule, sensors in expected["rules"].items():
        for sensor, want in sensors.items():
            have = report["rules"].get(rule, {}).get(sensor)
            if have is not None:
                apart += _differences(have, want, poses)
    return max(apart)


def _differences(have: dict[str, Any], want: dict[str, Any], poses: Sequence[str]) -> Iterable[float]:
    for figure in ("voa", "aecd"):
        if want[figure] is None or have[figure] is None:
            yield 0.0 if want[figure] == have[figure] else math.inf
        else:
            yield abs(have[figure] - want[figure])
    for measured, belief in want["belief_after_measured_scan"].items():
        for pose, share in zip(poses, have["beliefs"][measured], strict=True):
            yield abs(share - belief[pose])


def _print(console: Console, report: dict[str, Any]) -> None:
    before, prediction = report["before"], report["prediction"]
    grasp = before["best_grasp"] or "none"
    console.print(f"[bold]{report['experiment']}[/bold]: {len(report['poses'])} poses, uniform belief")
    console.print(f"best grasp before any look: [bold]{grasp}[/bold], expected score {before['expected_score']:.3f}\n")
    table = Table(title="What a look is worth, in success probability", title_justify="left")
    for heading in ("rule", "sensor", "VOA (predicted)", "AECD (measured)", "difference"):
        table.add_column(heading, justify="left" if heading in ("rule", "sensor") else "right")
    for rule, sensors in report["rules"].items():
        for index, (sensor, found) in enumerate(sensors.items()):
            aecd = found["aecd"]
            table.add_row(
                rule if index == 0 else "",
                sensor,
                f"{found['voa']:+.4f}",
                "-" if aecd is None else f"{aecd:+.4f}",
                "-" if aecd is None else f"{aecd - found['voa']:+.4f}",
                end_section=index == len(sensors) - 1,
            )
    console.print(table)
    if prediction["beams"] == 0:
        console.print("no beam has both a measured and a predicted range")
        return
    console.print(
        f"measured against predicted ({prediction['source']}) over {prediction['beams']} beams: median "
        f"{prediction['median_abs_mm']:.1f} mm, 95 % below {prediction['p95_abs_mm']:.1f} mm, "
        f"largest {prediction['max_abs_mm']:.1f} mm"
    )
    against = prediction["against_recorded"]
    if against is not None:
        console.print(
            f"mesh against recorded predictions over {against['beams']} beams: largest {against['max_abs_m']:.1e} m"
        )


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(prog="voa replay", description=(__doc__ or "").partition("\n\n")[2])
    parser.add_argument("folder", type=Path, help="folder of a recorded experiment, or a session file")
    parser.add_argument("--mesh", type=Path, help="of a session file: the object's mesh, where the service lacks it")
    parser.add_argument(
        "--predict", choices=["recorded", "mesh"], default="recorded", help="where predictions are from"
    )
    parser.add_argument("--json", action="store_true", help="print one JSON document")
    parser.add_argument("--url", help="a running service; without it, one is started for the purpose")
    parser.add_argument(
        "--rules",
        nargs="+",
        choices=[*RULES, "beam"],
        default=list(RULES),
        help=f"update rules (default {' '.join(RULES)})",
    )
    return parser
