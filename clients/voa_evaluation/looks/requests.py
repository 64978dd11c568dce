"""Requests of the evaluation to the service: scenarios under every update rule, rankings, updates."""

from collections.abc import Sequence
from dataclasses import dataclass

from voa_client import Client
from voa_evaluation.grasp_scores import GraspScores
from voa_evaluation.looks.setting import evaluated_update
from voa_fleet.episodes.forecasts import Forecast, forecast_of
from voa_fleet.world.objects import FleetObject
from voa_msgs.geometry import PoseUncertainty, SensorConfiguration, UncertainSensorPose
from voa_msgs.rankings import Look, Ranking, RankingRequest
from voa_msgs.scenarios import Scenario
from voa_msgs.sessions import Scan, UpdatedEstimate, UpdateRequest


@dataclass(frozen=True, eq=False)
class RegisteredObject:
    """Scenarios of an object in the service.

    Attributes:
        scenarios: by update rule.
        forecasts: predicted scans and updates by them, by update rule.
    """

    scenarios: dict[str, Scenario]
    forecasts: dict[str, Forecast]


@dataclass(frozen=True)
class EstimateBefore:
    """The service's estimate before any look.

    Attributes:
        ranking: of all looks.
        grasp: name of the best grasp; None if none can succeed.
        score: its expected score.
        voa: of each sensor configuration, in the scenario's order.
    """

    ranking: Ranking
    grasp: str | None
    score: float
    voa: tuple[float, ...]

    @property
    def look(self) -> str | None:
        """Name of the recommended sensor configuration; None: grasp now."""
        advice = self.ranking.recommendation
        return advice.sensor if isinstance(advice, Look) else None


def register(client: Client, target: FleetObject, scores: GraspScores, rules: Sequence[str]) -> RegisteredObject:
    """Store the object and its scenario under each update rule, and request a forecast under each.

    The scenarios state no spread, whatever the object's own one does: the paper compares scans with exact predictions.

    Args:
        client: of the service.
        target: the object.
        scores: grasp scores that replace the scenario's.
        rules: names of the update rules.

    Raises:
        VoaClientError: the service refuses a request, or does not answer.
    """
    mesh = client.create_object(target.folder / str(target.scenario.object), target.name)
    base = scores.scenario(target.scenario)
    scenarios = {}
    for rule in rules:
        changed = {
            "name": f"{target.name}, {rule}",
            "object": mesh.id,
            "update": evaluated_update(rule, base.update),
            "spread": None,
        }
        scenarios[rule] = client.create_scenario(base.model_copy(update=changed))
    return RegisteredObject(scenarios, {rule: forecast_of(client, scenario) for rule, scenario in scenarios.items()})


def estimate_before_look(client: Client, scenario: Scenario, belief: Sequence[float]) -> EstimateBefore:
    """Request the ranking and the best grasp under a belief (poses,)."""
    ranking = client.rank_once(RankingRequest(scenario=scenario.id, belief=list(belief)))
    voa = {look.sensor: look.voa for look in ranking.ranking}
    return EstimateBefore(
        ranking=ranking,
        grasp=ranking.best_grasp_before,
        score=ranking.expected_score_before,
        voa=tuple(voa[sensor.name] for sensor in scenario.sensors),
    )


def estimate_after_look(
    client: Client,
    scenario: Scenario,
    belief: Sequence[float],
    sensor: SensorConfiguration,
    scan: Scan,
    stated: PoseUncertainty | None = None,
) -> UpdatedEstimate:
    """Request the estimate after a scan.

    Args:
        client: of the service.
        scenario: with its update rule.
        belief: before the look, (poses,).
        sensor: sensor configuration of the look.
        scan: that was taken.
        stated: standard deviations of the lidar's pose that the robot states; None: it states none.
    """
    if stated is None:
        return client.update_once(
            UpdateRequest(scenario=scenario.id, belief=list(belief), sensor=sensor.name, scan=scan)
        )
    place = UncertainSensorPose(x=sensor.x, y=sensor.y, yaw_rad=sensor.yaw_rad, height_m=sensor.height_m, std=stated)
    return client.update_once(UpdateRequest(scenario=scenario.id, belief=list(belief), sensor_pose=place, scan=scan))
