"""Replay of the robots' scans in a recording: looks and places are recognised in them as in live scans.

Each robot of a mapping receives its own topics in the order of the recording. Robots whose mapping names the same
session share one here as well, a new session on the scenario that is replayed.
"""

from collections.abc import Sequence
from dataclasses import dataclass

from voa_client import Client, ProblemError
from voa_msgs.scenarios import Scenario
from voa_msgs.sessions import ScanRequest, SessionRequest, UpdatedSession
from voa_msgs.warnings import ProbableMistake
from voa_recordings.files.message import UnreadableRecording
from voa_recordings.files.reading import Recording
from voa_recordings.limits import most_beams
from voa_recordings.replay.mappings import check_places
from voa_recordings.robot_looks import RobotLooks, grid_of, raise_without_scans
from voa_ros.looks import GatheredLook, look_name
from voa_ros.robots import RobotMapping


@dataclass(frozen=True)
class ReplayedLook:
    """A look of a recording, with the service's response, or with the reason why the service refused it."""

    robot: str
    request: ScanRequest
    response: UpdatedSession | None
    refused: str | None


@dataclass(frozen=True)
class ReplayedRobot:
    """Scans and looks of one robot in a recording.

    Attributes:
        robot: its name in the mapping.
        session: id of the session that received its looks.
        scans: number of its scans in the recording.
        looks: number of its looks that were sent.
        waiting_for: the condition for another look that was not met at the end; None: there is none.
        warnings: probable mistakes in how the robot was used.
        unreadable: why the newest message that could not be used was not; None: all could.
    """

    robot: str
    session: str
    scans: int
    looks: int
    waiting_for: str | None
    warnings: Sequence[ProbableMistake]
    unreadable: str | None


@dataclass(frozen=True)
class LooksReport:
    """Looks of a recording that were sent to a service.

    Attributes:
        scenario: that the sessions are on.
        robots: in the order of the mapping.
        looks: in the order of the recording.
        messages: number of messages that were read from the recording.
        damage: of the recording, as predicates ("ends in the middle"); None: none.
    """

    scenario: Scenario
    robots: Sequence[ReplayedRobot]
    looks: Sequence[ReplayedLook]
    messages: int
    damage: str | None


def replay_looks(
    client: Client, recording: Recording, scenario: Scenario, mappings: Sequence[RobotMapping]
) -> LooksReport:
    """Send the looks of a recording to new sessions on a scenario.

    Args:
        client: of the service.
        recording: with LaserScan topics.
        scenario: stored on the service.
        mappings: of the robots.

    Raises:
        InvalidMapping: a mapping does not fit the scenario.
        UnreadableRecording: the recording cannot be read, or has no scans of these robots; no session is left behind.
        VoaClientError: the service cannot be reached.
    """
    check_places(mappings, scenario)
    grid, most = grid_of(scenario), most_beams()
    sessions: dict[str, str] = {}
    robots: list[_Robot] = []
    for mapping in mappings:
        target = mapping.session or mapping.scenario or ""
        if target not in sessions:
            sessions[target] = client.create_session(SessionRequest(scenario=scenario.id)).id
        robots.append(_Robot(sessions[target], RobotLooks(mapping, grid, most)))
    looks: list[ReplayedLook] = []
    try:
        _send_looks(client, recording, robots, looks)
    except UnreadableRecording:
        if not looks:
            for session in sessions.values():
                client.delete_session(session)
        raise
    reports = [robot.report(sum(look.robot == robot.looks.name for look in looks)) for robot in robots]
    return LooksReport(scenario, reports, looks, recording.recovered, recording.damage)


class _Robot:
    """A robot of the mapping, and the session that receives its looks."""

    def __init__(self, session: str, looks: RobotLooks) -> None:
        self.looks = looks
        self.session = session
        self._accepted = 0

    def send(self, client: Client, taken: GatheredLook) -> ReplayedLook:
        """Send a look; if it is not accepted, the next revolutions of the same stop make another."""
        key = look_name(self.looks.name, self.session, self._accepted + 1, taken)
        try:
            response = client.apply_scan(self.session, taken.request, key=key)
        except ProblemError as error:
            refused = f"{error.kind}: {error.problem.detail}"
            self.looks.pipeline.rejected(refused)
            return ReplayedLook(self.looks.name, taken.request, None, refused)
        if response.update.accepted:
            self._accepted += 1
        else:
            self.looks.pipeline.rejected(response.update.reason or "not accepted")
        return ReplayedLook(self.looks.name, taken.request, response, None)

    def report(self, looks: int) -> ReplayedRobot:
        """Sum up what was received, and `looks`, the number of looks that were sent."""
        return ReplayedRobot(
            robot=self.looks.name,
            session=self.session,
            scans=self.looks.scans,
            looks=looks,
            waiting_for=self.looks.pipeline.waiting_for,
            warnings=self.looks.pipeline.warnings,
            unreadable=self.looks.unreadable,
        )


def _send_looks(client: Client, recording: Recording, robots: Sequence[_Robot], looks: list[ReplayedLook]) -> None:
    """Append each look that was sent to `looks`; raises UnreadableRecording where no robot has a scan."""
    for message in recording.messages():
        for robot in robots:
            taken = robot.looks.receive(message)
            if taken is not None:
                looks.append(robot.send(client, taken))
    raise_without_scans([robot.looks for robot in robots], recording)
