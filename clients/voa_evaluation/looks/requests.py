"""What the evaluation asks of the service about one object: the scenario under every rule, rankings, updates."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from voa_client import Client
from voa_evaluation.grasp_scores import GraspScores
from voa_evaluation.looks.setting import update_of
from voa_fleet.world.frames import Floats
from voa_fleet.world.objects import FleetObject
from voa_msgs.geometry import PoseUncertainty, SensorConfiguration, UncertainSensorPose
from voa_msgs.rankings import RankingRequest
from voa_msgs.scenarios import Scenario
from voa_msgs.sessions import Scan, UpdatedEstimate, UpdateRequest


@dataclass(frozen=True, eq=False)
class Asked:
    """An object as the service knows it.

    Attributes:
        scenarios: by rule.
        visible: sensors x poses, how many beams are predicted to meet the object.
        likelihoods: by rule, sensors x poses x poses: what a uniform belief becomes, by the service's answer, after
            the scan that is predicted at [s, p].
    """

    scenarios: dict[str, Scenario]
    visible: Floats
    likelihoods: dict[str, Floats]


@dataclass(frozen=True)
class Beforehand:
    """What the service says before any look.

    Attributes:
        grasp: the best one; None if none can succeed.
        score: its expected score.
        voa: per sensor configuration, in the scenario's order.
        look: name of the recommended one; None: grasp now.
    """

    grasp: str | None
    score: float
    voa: tuple[float, ...]
    look: str | None


def ask(client: Client, target: FleetObject, scores: GraspScores, rules: Sequence[str]) -> Asked:
    """Store the object and its scenario under each rule; learn what can be seen, and what each scan would say.

    Raises:
        VoaClientError: the service cannot be reached, or refuses.
    """
    mesh = client.create_object(target.folder / str(target.scenario.object), target.name)
    base = scores.scenario(target.scenario)
    scenarios = {}
    for rule in rules:
        told = {"name": f"{target.name}, {rule}", "object": mesh.id, "update": update_of(rule, base.update)}
        scenarios[rule] = client.create_scenario(base.model_copy(update=told))
    predicted = client.predict(scenarios[rules[0]].id).ranges
    visible = np.array([[sum(value is not None for value in scan) for scan in row] for row in predicted], dtype=float)
    scans = [[_as_scan(ranges) for ranges in row] for row in predicted]
    likelihoods = {rule: _likelihoods(client, scenarios[rule], scans) for rule in rules}
    return Asked(scenarios, visible, likelihoods)


def _as_scan(ranges: Sequence[float | None]) -> Scan:
    nothing = [index for index, value in enumerate(ranges) if value is None]
    return Scan(ranges=[0.0 if value is None else value for value in ranges], no_return=nothing)


def _likelihoods(client: Client, scenario: Scenario, scans: list[list[Scan]]) -> Floats:
    even = [1.0 / len(scenario.poses)] * len(scenario.poses)
    return np.array(
        [
            [
                client.update_once(
                    UpdateRequest(scenario=scenario.id, belief=even, sensor=sensor.name, scan=scan)
                ).belief
                for scan in row
            ]
            for sensor, row in zip(scenario.sensors, scans, strict=True)
        ]
    )


def before_any_look(client: Client, scenario: Scenario, belief: Sequence[float]) -> Beforehand:
    """The ranking under a belief."""
    told = client.rank_once(RankingRequest(scenario=scenario.id, belief=list(belief)))
    voa = {look.sensor: look.voa for look in told.ranking}
    advice = told.recommendation
    return Beforehand(
        grasp=told.best_grasp_before,
        score=told.expected_score_before,
        voa=tuple(voa[sensor.name] for sensor in scenario.sensors),
        look=advice.sensor if advice.action == "look" else None,
    )


def after_a_look(
    client: Client,
    scenario: Scenario,
    belief: Sequence[float],
    sensor: SensorConfiguration,
    scan: Scan,
    stated: PoseUncertainty | None = None,
) -> UpdatedEstimate:
    """The estimate after a scan from a sensor configuration, as exactly known as is `stated`; None: exactly."""
    if stated is None:
        return client.update_once(
            UpdateRequest(scenario=scenario.id, belief=list(belief), sensor=sensor.name, scan=scan)
        )
    place = UncertainSensorPose(x=sensor.x, y=sensor.y, yaw_rad=sensor.yaw_rad, height_m=sensor.height_m, std=stated)
    return client.update_once(UpdateRequest(scenario=scenario.id, belief=list(belief), sensor_pose=place, scan=scan))


def expected_entropies(likelihoods: Floats, belief: Sequence[float]) -> Floats:
    """The entropy expected after a look from each sensor configuration, (sensors,), nats, over predicted scans.

    Args:
        likelihoods: sensors x poses x poses, as `Asked` has them.
        belief: before the look, (poses,).
    """
    prior = np.asarray(belief, dtype=np.float64)
    joint = likelihoods * prior
    total = joint.sum(axis=2, keepdims=True)
    after = np.divide(joint, total, out=np.broadcast_to(prior, joint.shape).copy(), where=total > 0.0)
    logs = np.log(np.where(after > 0.0, after, 1.0))
    entropies: Floats = -(after * logs).sum(axis=2) @ prior
    return entropies
