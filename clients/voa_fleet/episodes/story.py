"""The story of one pair: a sensor robot and an arm, customers of one session.

    open a session -> rank -> drive -> look -> send -> ... -> grasp -> report

They know the service through its client alone, and each other through the session alone. What happens is told as
events, to whoever wants to know: nothing is printed here.
"""

from collections.abc import Callable
from dataclasses import dataclass

from voa_client import ArmClient, Client
from voa_fleet.devices.clocks import Clock
from voa_fleet.devices.protocol import Arm, GraspOutcome, SensorRobot
from voa_fleet.devices.session_looks import Looking, TakenLook
from voa_fleet.episodes.policies import Policy, Situation
from voa_msgs.geometry import SensorPose
from voa_msgs.rankings import Ranking, VoaRequest
from voa_msgs.scenarios import Scenario
from voa_msgs.sessions import Session, UpdatedSession

MOST_LOOKS = 3
MOVED_M = 0.01
"""An object that an attempt has moved by more does not lie where the belief has it."""


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


@dataclass(frozen=True, eq=False)
class Pair:
    """Who plays.

    Attributes:
        name: of the pair.
        client: of the service; its own, or one that threads may share.
        robot: carries the lidar.
        arm: grasps.
        looking: opens the session and brings looks to it.
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
        DeviceError: a device cannot do what it is asked, or its robot's mapping does not fit.
    """
    began = pair.clock.now_s()

    def say(what: Happening) -> None:
        tell(Event(pair.name, pair.clock.now_s() - began, what))

    before = pair.looking.open(scenario)
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
