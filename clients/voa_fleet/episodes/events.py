"""Events of an episode: each step that a pair has taken, for a listener to show or to keep."""

from collections.abc import Callable
from dataclasses import dataclass

from voa_fleet.devices.protocol import GraspOutcome
from voa_fleet.episodes.looks import EpisodeLook
from voa_msgs.geometry import SensorPose
from voa_msgs.rankings import Ranking
from voa_msgs.sessions import Session, UpdatedSession


@dataclass(frozen=True)
class SessionOpened:
    """The pair has opened a session."""

    session: Session


@dataclass(frozen=True)
class LookChosen:
    """The policy has chosen to look from a sensor configuration, or to grasp.

    Attributes:
        sensor: name of the sensor configuration; None: grasp.
        ranking: the service's ranking of the looks, where the policy requested it.
        min_gain: net value that a look has to exceed for the service to recommend it.
        used_up: True if the policy wants another look and the episode allows no more.
    """

    sensor: str | None
    ranking: Ranking | None
    min_gain: float
    used_up: bool = False


@dataclass(frozen=True)
class RobotArrived:
    """The robot stands at the sensor configuration, as far as it knows."""

    sensor: str
    pose: SensorPose


@dataclass(frozen=True)
class LookTaken:
    """The session has processed a look."""

    look: EpisodeLook


@dataclass(frozen=True)
class GraspStarted:
    """The arm begins an attempt.

    Attributes:
        grasp: name of the grasp; None: no grasp within reach is expected to succeed.
        expected_score: probability of success that the service expects.
    """

    grasp: str | None
    expected_score: float


@dataclass(frozen=True)
class GraspEnded:
    """The arm has ended an attempt."""

    outcome: GraspOutcome


@dataclass(frozen=True)
class OutcomeReported:
    """The outcome of the attempt was reported.

    Attributes:
        after: the session after the report.
        moved: True if the attempt was reported to have moved the object.
    """

    after: UpdatedSession
    moved: bool = False


Step = SessionOpened | LookChosen | RobotArrived | LookTaken | GraspStarted | GraspEnded | OutcomeReported


@dataclass(frozen=True)
class Event:
    """A step of a pair, with its time.

    Attributes:
        pair: name of the pair.
        at_s: seconds since the episode began, by the pair's clock.
        step: that was taken.
    """

    pair: str
    at_s: float
    step: Step


Listener = Callable[[Event], None]
"""Function that is called with each event of an episode, in order."""


def ignore(_event: Event) -> None:
    """Do nothing with an event."""
