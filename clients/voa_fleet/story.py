"""The story of one pair: a sensor robot and an arm, customers of one session.

    open a session -> rank -> drive -> look -> send -> ... -> grasp -> report

They know the service through its client alone, and each other through the session alone. What happens is told as
events, to whoever wants to know: nothing is printed here.
"""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Protocol

from voa_client import ArmClient, Client
from voa_fleet.clocks import Clock
from voa_fleet.devices import Arm, GraspOutcome, SensorRobot
from voa_fleet.lidar import LidarGeometry, lidar_geometry
from voa_fleet.looking import REVOLUTIONS, median_look
from voa_fleet.policies import Policy, Situation
from voa_msgs.geometry import SensorConfiguration, SensorPose
from voa_msgs.rankings import Ranking, VoaRequest
from voa_msgs.scenarios import Scenario
from voa_msgs.sessions import ScanRequest, Session, SessionRequest, UpdatedSession, UpdateReport

MOST_LOOKS = 3
MOVED_M = 0.01
"""An object that an attempt has moved by more does not lie where the belief has it."""


@dataclass(frozen=True)
class TakenLook:
    """A look that the session has.

    Attributes:
        sensor: where the robot was sent.
        request: what the service was told; None where that is not known.
        after: the session then.
        update: what the look did to it; None: it was not accepted, and nobody says why.
    """

    sensor: str
    request: ScanRequest | None
    after: Session
    update: UpdateReport | None


@dataclass(frozen=True)
class Opened:
    """The session is open."""

    session: Session


@dataclass(frozen=True)
class Chosen:
    """It is decided from where to look, or to grasp.

    Attributes:
        sensor: from where; None: grasp.
        ranking: what the service said of the looks, where it was asked.
        min_gain: what a look's net value has to exceed for the service to recommend it.
        used_up: whether one more look would be wanted, and there are none left.
    """

    sensor: str | None
    ranking: Ranking | None
    min_gain: float
    used_up: bool = False


@dataclass(frozen=True)
class Arrived:
    """The robot stands where it was sent, as far as it knows."""

    sensor: str
    pose: SensorPose


@dataclass(frozen=True)
class Looked:
    """The session has the look."""

    look: TakenLook


@dataclass(frozen=True)
class Grasping:
    """The arm is about to try.

    Attributes:
        grasp: None: none that it can reach is expected to succeed.
    """

    grasp: str | None
    expected_score: float


@dataclass(frozen=True)
class Grasped:
    """The arm has tried."""

    outcome: GraspOutcome


@dataclass(frozen=True)
class Reported:
    """The service knows how it went.

    Attributes:
        after: the session then; None: it was not told, because the attempt has moved the object, and the belief is
            about where it was.
    """

    after: UpdatedSession | None


Happening = Opened | Chosen | Arrived | Looked | Grasping | Grasped | Reported


@dataclass(frozen=True)
class Event:
    """Something has happened.

    Attributes:
        pair: to whom.
        at_s: when, by the pair's clock.
        what: what.
    """

    pair: str
    at_s: float
    what: Happening


Tell = Callable[[Event], None]


def untold(_event: Event) -> None:
    """Nobody listens."""


class Looking(Protocol):
    """How a look gets from the robot to the session."""

    def look(self, session: Session, sensor: SensorConfiguration) -> TakenLook:
        """Look from where the robot stands, until the session has it or has refused it."""


@dataclass(frozen=True, eq=False)
class Pair:
    """Who plays.

    Attributes:
        name: of the pair.
        client: of the service; its own, or one that threads may share.
        robot: carries the lidar.
        arm: grasps.
        looking: sends looks.
        clock: tells when things happened.
    """

    name: str
    client: Client
    robot: SensorRobot
    arm: Arm
    looking: Looking
    clock: Clock


@dataclass(frozen=True)
class Story:
    """What it came to.

    Attributes:
        pair: whose.
        policy: that chose the looks.
        before: the session as it was opened.
        looks: in order.
        grasp: that was tried; None: there was none worth trying.
        expected_score: of it, before it was tried.
        outcome: of it.
        seconds: by the pair's clock.
    """

    pair: str
    policy: str
    before: Session
    looks: tuple[TakenLook, ...]
    grasp: str | None
    expected_score: float
    outcome: GraspOutcome | None
    seconds: float

    @property
    def success(self) -> bool:
        """Whether the object was lifted."""
        return self.outcome is not None and self.outcome.success


def play(pair: Pair, scenario: Scenario, policy: Policy, most_looks: int = MOST_LOOKS, tell: Tell = untold) -> Story:
    """Open a session, look as the policy says, grasp, report.

    Raises:
        VoaClientError: the service refuses something, or does not answer.
        DeviceError: a device cannot do what it is asked.
    """
    began = pair.clock.now_s()

    def say(what: Happening) -> None:
        tell(Event(pair.name, pair.clock.now_s() - began, what))

    before = pair.client.create_session(SessionRequest(scenario=scenario.id))
    say(Opened(before))
    reachable = list(pair.arm.reachable())
    looks = _look_around(pair, scenario, before, policy, most_looks, reachable, say) if reachable else ()
    arm = ArmClient(pair.client, before.id)
    best = arm.best_grasp(reachable) if reachable else None
    grasp, expected = (None, 0.0) if best is None else (best.name, best.expected_score)
    say(Grasping(grasp, expected))
    outcome = None
    if best is not None:
        outcome = pair.arm.attempt(best.name)
        say(Grasped(outcome))
        moved = not outcome.success and outcome.moved_m is not None and outcome.moved_m > MOVED_M
        say(Reported(None if moved else arm.report(best.name, outcome.success)))
    return Story(pair.name, policy.name, before, looks, grasp, expected, outcome, pair.clock.now_s() - began)


def _look_around(
    pair: Pair,
    scenario: Scenario,
    session: Session,
    policy: Policy,
    most_looks: int,
    reachable: list[str],
    say: Callable[[Happening], None],
) -> tuple[TakenLook, ...]:
    sensors = {sensor.name: sensor for sensor in scenario.sensors}
    looks: list[TakenLook] = []
    while True:
        visited = tuple(look.sensor for look in looks)
        situation = Situation(
            tuple(scenario.sensors),
            visited,
            pair.robot.pose(),
            lambda: pair.client.rank_looks(session.id, VoaRequest(grasps=reachable)),
        )
        choice = policy.choose(situation)
        if choice.sensor is None or len(looks) == most_looks:
            say(Chosen(None, choice.ranking, scenario.min_gain, used_up=choice.sensor is not None))
            return tuple(looks)
        say(Chosen(choice.sensor, choice.ranking, scenario.min_gain))
        sensor = sensors[choice.sensor]
        pair.robot.drive_to(sensor)
        say(Arrived(sensor.name, pair.robot.pose()))
        looks.append(pair.looking.look(session, sensor))
        say(Looked(looks[-1]))


@dataclass(frozen=True, eq=False)
class ByClient:
    """Looks that go through the client, as scans of the contract.

    A robot that states how well it knows its pose sends that pose along; one that states nothing stands at the
    configuration that it was sent to.

    Attributes:
        client: of the service.
        robot: that looks.
        lidar: its beams.
        revolutions: in one look.
    """

    client: Client
    robot: SensorRobot
    lidar: LidarGeometry
    revolutions: int = REVOLUTIONS

    def look(self, session: Session, sensor: SensorConfiguration) -> TakenLook:
        """The median of some revolutions, and where they were taken.

        Raises:
            VoaClientError: the service refuses it, or does not answer.
            DeviceError: no scan came.
        """
        scan = median_look([self.robot.take_scan() for _ in range(self.revolutions)], self.lidar)
        pose = self.robot.pose()
        request = (
            ScanRequest(sensor=sensor.name, scan=scan) if pose.std is None else ScanRequest(sensor_pose=pose, scan=scan)
        )
        after = self.client.apply_scan(session.id, request)
        return TakenLook(sensor.name, request, after, after.update)


def looking_by(client: Client, robot: SensorRobot, scenario: Scenario, revolutions: int = REVOLUTIONS) -> ByClient:
    """Looks through the client, with the beams that the scenario states.

    Raises:
        FleetError: the scenario's lidar is not known.
    """
    return ByClient(client, robot, lidar_geometry(scenario.lidar), revolutions)
