"""Replay of recorded experiments: every measured scan is sent to a service, and the values of looks are reported.

For every update rule and sensor configuration: the Value of Assistance before the look, the value of the look with the
scans that were measured (AECD), and the differences between measured and predicted ranges.
"""

import math
from collections.abc import Callable, Sequence

from voa_client import Client
from voa_msgs.geometry import CandidateSensor, SensorConfiguration
from voa_msgs.lidars import Lidar
from voa_msgs.rankings import RankingRequest
from voa_msgs.scenarios import GivenScores, Grasp, MeasuredScores, Pose, PredictionsRequest, ScenarioRequest
from voa_msgs.sessions import Scan, UpdateRequest
from voa_msgs.updates import BUILT_IN, PAPER_RULES, MarginUpdate, PluginUpdate, UpdateRule, default_update
from voa_recordings.experiment import RecordedExperiment
from voa_recordings.experiment_parts import InvalidExperiment
from voa_recordings.replay.experiment_report import BeforeLooks, ExperimentReport, LookValue
from voa_recordings.replay.prediction_errors import Predictions, Source, prediction_errors

_LONGEST_NAME = 100


def replay_experiment(
    client: Client,
    experiment: RecordedExperiment,
    source: Source,
    rules: Sequence[str] = PAPER_RULES,
    progress: Callable[[int, int], None] | None = None,
) -> ExperimentReport:
    """Send every measured scan of an experiment to a service, and report the values of looks.

    Args:
        client: of the service.
        experiment: with measured scans.
        source: of the predictions: the experiment's `scans.csv`, or the experiment's mesh.
        rules: names of update rules, at least one.
        progress: called with the number of finished and of all pairs of rule and sensor.

    Raises:
        InvalidExperiment: predictions from the mesh are requested, and the mesh or the geometry is missing.
        VoaClientError: the service cannot be reached, or refuses.
    """
    recorded = {
        sensor.name: {pose: experiment.predicted_ranges(sensor.name, pose) for pose in experiment.pose_names}
        for sensor in experiment.sensors
    }
    predictions = recorded if source == "recorded" else predict_from_mesh(client, experiment)
    belief = [1.0 / len(experiment.poses)] * len(experiment.poses)
    total = len(rules) * len(experiment.sensors)
    values: dict[str, dict[str, LookValue]] = {}
    for done, rule in enumerate(rules):
        scenario = client.create_scenario(
            _scenario(experiment, paper_update(rule, experiment.no_return_m), predictions)
        )
        ranking = client.rank_once(RankingRequest(scenario=scenario.id, belief=belief))
        before = BeforeLooks(best_grasp=ranking.best_grasp_before, expected_score=ranking.expected_score_before)
        voa = {look.sensor: look.voa for look in ranking.ranking}
        values[rule] = {}
        for index, sensor in enumerate(experiment.sensors, start=1):
            beliefs, aecd = _measured_value(client, experiment, scenario.id, sensor.name, before.expected_score)
            values[rule][sensor.name] = LookValue(voa=voa[sensor.name], aecd=aecd, beliefs=beliefs)
            if progress is not None:
                progress(done * len(experiment.sensors) + index, total)
    return ExperimentReport(
        experiment=experiment.name,
        poses=experiment.pose_names,
        sensors=[sensor.name for sensor in experiment.sensors],
        before=before,
        rules=values,
        prediction=prediction_errors(experiment, predictions, source),
        selection=experiment.selection,
    )


def _measured_value(
    client: Client, experiment: RecordedExperiment, scenario: str, sensor: str, score_before: float
) -> tuple[dict[str, list[float]], float | None]:
    """Update a uniform belief by each scan that was measured from a sensor; return the beliefs, and the AECD."""
    uniform = [1.0 / len(experiment.poses)] * len(experiment.poses)
    beliefs: dict[str, list[float]] = {}
    scores = []
    for pose in experiment.pose_names:
        if not experiment.scan(sensor, pose).was_measured:
            continue
        ranges = experiment.measured_ranges(sensor, pose)
        no_returns = [index for index, value in enumerate(ranges) if value is None]
        scan = Scan(ranges=ranges, no_return=no_returns, range_min=0.0)
        after = client.update_once(UpdateRequest(scenario=scenario, belief=uniform, sensor=sensor, scan=scan))
        beliefs[pose] = after.belief
        scores.append(after.expected_score)
    everywhere = len(scores) == len(uniform)
    return beliefs, math.fsum(scores) / len(scores) - score_before if everywhere else None


def predict_from_mesh(client: Client, experiment: RecordedExperiment) -> Predictions:
    """Predict the scan of every sensor and pose from the experiment's mesh, each at the plane height of its own scan.

    Raises:
        InvalidExperiment: the mesh, plane heights, poses' geometry or sensors' positions are missing.
        VoaClientError: the service cannot be reached, or refuses.
    """
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
    any_update = default_update(PAPER_RULES[0])  # a scenario needs one, and predictions do not depend on it
    scenario = client.create_scenario(_scenario(experiment, any_update, None, mesh.id))
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
    own = experiment.lidar
    lidar = Lidar(
        beams=own.beams,
        angle_min=math.radians(own.angle_min_deg),
        angle_increment=math.radians(own.angle_increment_deg),
        range_min=own.range_min,
        range_max=max(own.range_max, experiment.no_return_m),
        zero="missing",
    )
    if experiment.scores is not None:
        scores: GivenScores | MeasuredScores = GivenScores(probabilities=experiment.scores)
    else:
        scores = MeasuredScores(attempts=experiment.attempts or 0, successes=experiment.successes or [])
    return ScenarioRequest(
        name=f"{experiment.name[:_LONGEST_NAME]}, {rule_name(update)}",
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


def rule_name(update: UpdateRule) -> str:
    """Name of an update rule, built in or of another package."""
    return update.name if isinstance(update, PluginUpdate) else update.rule


def paper_update(rule: str, no_return_m: float | None) -> UpdateRule:
    """Return an update rule with its default parameters, as the papers use it.

    There, `margin` shares the belief among the nearest poses where a scan matches none; the others always match.

    Args:
        rule: its name; one that is not built in is a rule that another package provides to the service.
        no_return_m: range that a no-return counts as, metres; None: the lidar's `range_max`.
    """
    return default_update(rule, no_return_m, "nearest" if BUILT_IN.get(rule) is MarginUpdate else "reject")
