"""An episode of one pair: a sensor robot and an arm that share a session.

    open a session -> rank -> drive -> look -> send -> ... -> grasp -> report

They know the service through its client alone, and each other through the session alone. Each step is an event for a
listener; nothing is printed here.
"""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from voa_client import ArmClient, Client, poses_of
from voa_fleet.devices.protocol import Arm, GraspOutcome, SensorRobot
from voa_fleet.episodes.events import (
    Event,
    GraspEnded,
    GraspStarted,
    Listener,
    LookChosen,
    LookTaken,
    OutcomeReported,
    RobotArrived,
    SessionOpened,
    Step,
    ignore,
)
from voa_fleet.episodes.forecasts import forecast_of
from voa_fleet.episodes.looks import EpisodeLook, LookChannel
from voa_fleet.episodes.policies import Policy, Situation
from voa_fleet.world.clocks import Clock
from voa_msgs.rankings import VoaRequest
from voa_msgs.scenarios import Scenario
from voa_msgs.sessions import Session

MOST_LOOKS = 3
"""Looks in an episode, unless stated otherwise."""
MOVED_M = 0.01
"""Distance above which a failed attempt is reported to have moved the object, so that earlier looks do not count."""


@dataclass(frozen=True, eq=False)
class Pair:
    """A sensor robot and an arm, and their way to the service.

    Attributes:
        name: of the pair.
        client: of the service; its own, or one that threads may share.
        robot: carries the lidar.
        arm: grasps.
        channel: opens the session and brings looks to it.
        clock: gives the times of events.
    """

    name: str
    client: Client
    robot: SensorRobot
    arm: Arm
    channel: LookChannel
    clock: Clock


@dataclass(frozen=True)
class Episode:
    """Result of an episode.

    Attributes:
        pair: name of the pair.
        policy: name of the policy that chose the looks.
        before: the session when it was opened.
        looks: in order.
        grasp: name of the attempted grasp; None: none was worth an attempt.
        expected_score: its probability of success, as the service expected it.
        outcome: of the attempt; None: there was none.
        seconds: duration by the pair's clock.
    """

    pair: str
    policy: str
    before: Session
    looks: tuple[EpisodeLook, ...]
    grasp: str | None
    expected_score: float
    outcome: GraspOutcome | None
    seconds: float

    @property
    def success(self) -> bool:
        """True if the object was lifted."""
        return self.outcome is not None and self.outcome.success


def run_episode(
    pair: Pair,
    scenario: Scenario,
    policy: Policy,
    most_looks: int = MOST_LOOKS,
    listener: Listener = ignore,
    seed: int | tuple[int, ...] = 0,
) -> Episode:
    """Open a session, look as the policy chooses, attempt the best grasp, report its outcome.

    Args:
        pair: the devices and their client.
        scenario: on which the session is opened.
        policy: chooses the looks.
        most_looks: number of looks after which the pair grasps in any case.
        listener: called with each event.
        seed: of the policy's random choices.

    Raises:
        VoaClientError: the service refuses a request, or does not answer.
        DeviceError: a device cannot do what was requested, or the mapping of its robot does not fit.
    """
    began = pair.clock.now_s()

    def publish(step: Step) -> None:
        listener(Event(pair.name, pair.clock.now_s() - began, step))

    before = pair.channel.open(scenario)
    publish(SessionOpened(before))
    reachable = list(pair.arm.reachable())
    surroundings = _Surroundings(pair, scenario, before, reachable, np.random.default_rng(seed))
    looks = _take_looks(surroundings, policy, most_looks, publish) if reachable else ()
    arm = ArmClient(pair.client, before.id)
    best = arm.best_grasp(reachable) if reachable else None
    grasp, expected = (None, 0.0) if best is None else (best.name, best.expected_score)
    publish(GraspStarted(grasp, expected))
    outcome = None
    if best is not None:
        outcome = pair.arm.attempt(best.name)
        publish(GraspEnded(outcome))
        moved = not outcome.success and outcome.moved_m is not None and outcome.moved_m > MOVED_M
        publish(OutcomeReported(arm.report(best.name, outcome.success, object_moved=float(moved)), moved=moved))
    return Episode(pair.name, policy.name, before, looks, grasp, expected, outcome, pair.clock.now_s() - began)


@dataclass(frozen=True, eq=False)
class _Surroundings:
    """Everything that the situations of an episode are made from, apart from its looks."""

    pair: Pair
    scenario: Scenario
    session: Session
    reachable: list[str]
    rng: np.random.Generator

    def situation(self, looks: list[EpisodeLook], looks_left: int) -> Situation:
        session = looks[-1].after if looks else self.session
        client = self.pair.client
        return Situation(
            sensors=tuple(self.scenario.sensors),
            visited=tuple(look.sensor for look in looks),
            robot=self.pair.robot.pose(),
            belief=tuple(session.belief),
            rank=lambda: client.rank_looks(self.session.id, self._ranking_request()),
            forecast=lambda: forecast_of(client, self.scenario),
            draw=lambda count: int(self.rng.integers(count)),
            looks_left=looks_left,
        )

    def _ranking_request(self) -> VoaRequest:
        """Make the request for a ranking; for a robot that states its errors it names poses, as with its scans."""
        std = self.pair.robot.pose().std
        if std is None:
            return VoaRequest(grasps=self.reachable)
        return VoaRequest(sensors=list(poses_of(self.scenario)), grasps=self.reachable, sensor_std=std)


def _take_looks(
    surroundings: _Surroundings, policy: Policy, most_looks: int, publish: Callable[[Step], None]
) -> tuple[EpisodeLook, ...]:
    pair, scenario = surroundings.pair, surroundings.scenario
    sensors = {sensor.name: sensor for sensor in scenario.sensors}
    looks: list[EpisodeLook] = []
    while True:
        choice = policy.choose(surroundings.situation(looks, most_looks - len(looks)))
        if choice.sensor is None or len(looks) == most_looks:
            publish(LookChosen(None, choice.ranking, scenario.min_gain, used_up=choice.sensor is not None))
            return tuple(looks)
        publish(LookChosen(choice.sensor, choice.ranking, scenario.min_gain))
        sensor = sensors[choice.sensor]
        pair.robot.drive_to(sensor)
        publish(RobotArrived(sensor.name, pair.robot.pose()))
        looks.append(pair.channel.look(surroundings.session, sensor))
        publish(LookTaken(looks[-1]))
