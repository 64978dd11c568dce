"""Recorded experiments through the service: the report of `voa replay DIR`.

For every update rule and sensor configuration: the Value of Assistance beforehand, what the look was worth with
the scans that were really measured (AECD), and how far measurement and prediction are apart.
"""

import math
from collections.abc import Sequence
from typing import Any

from rich.console import Console
from rich.markup import escape
from rich.progress import Progress
from rich.table import Table

from voa_client import Client
from voa_client.formatting import share, signed
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
from voa_recordings.experiment import InvalidExperiment, RecordedExperiment
from voa_recordings.replay.figures import Predictions, Source, prediction_errors

RULES = ("margin", "exponential", "gaussian", "inverse_rmsd")
_LONGEST_NAME = 100


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
        scenario = client.create_scenario(_scenario(experiment, update_of(rule, experiment.no_return_m), predictions))
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
        "prediction": prediction_errors(experiment, predictions, source),
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
    if not all({"x", "y", "yaw_deg"} <= sensor.model_fields_set for sensor in experiment.sensors):
        raise InvalidExperiment(f"{experiment.name}: predictions from the mesh need x, y and yaw_deg of every sensor")
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


def update_of(rule: str, no_return_m: float | None) -> UpdateRule:
    """A rule with its defaults; `margin` shares the belief among the nearest poses, as the paper's lab did."""
    match rule:
        case "margin":
            return MarginUpdate(rule="margin", no_return_m=no_return_m, on_no_match="nearest")
        case "exponential":
            return ExponentialUpdate(rule="exponential", no_return_m=no_return_m)
        case "gaussian":
            return GaussianUpdate(rule="gaussian", no_return_m=no_return_m)
        case "inverse_rmsd":
            return InverseRmsdUpdate(rule="inverse_rmsd", no_return_m=no_return_m)
        case _:
            return BeamUpdate(rule="beam", no_return_m=no_return_m)


def show(console: Console, report: dict[str, Any]) -> None:
    """The report as a table."""
    before, prediction = report["before"], report["prediction"]
    score = share(before["expected_score"], 3)
    console.print(f"{report['experiment']}: {len(report['poses'])} poses, uniform belief", style="bold", markup=False)
    console.print(
        f"best grasp before any look: {before['best_grasp'] or 'none'}, expected score {score}\n", markup=False
    )
    table = Table(title="What a look is worth, in success probability", title_justify="left")
    for heading in ("rule", "sensor", "VOA (predicted)", "AECD (measured)", "difference"):
        table.add_column(heading, justify="left" if heading in ("rule", "sensor") else "right")
    for rule, sensors in report["rules"].items():
        for index, (sensor, found) in enumerate(sensors.items()):
            aecd = found["aecd"]
            table.add_row(
                rule if index == 0 else "",
                escape(sensor),
                signed(found["voa"], 4),
                "-" if aecd is None else signed(aecd, 4),
                "-" if aecd is None else signed(aecd - found["voa"], 4),
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
