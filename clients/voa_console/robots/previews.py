"""Previews: the newest scan of each robot, with the scenario and the mirror and rotation test that belong to it."""

import time
from collections.abc import Callable
from dataclasses import dataclass, field

from voa_client import AsyncClient, DeniedError, NotFoundError, RobotReport, RobotScan, Scan, Scenario, VoaClientError
from voa_console.robots.comparing import Comparison, compare, place_of, predicted
from voa_console.robots.readings import AS_MEASURED, Reading, differs
from voa_console.sentences import needs_key, sentence_of
from voa_console.watching.hub import Hub
from voa_msgs.geometry import UncertainSensorPose
from voa_ros.look_taker import MOVE_ON
from voa_ros.motions import within

MOST = 20
"""Most robots whose scans are requested."""
AGAIN_S = 30.0
"""Time after which the scan of a robot that stands still is compared again, seconds."""
SOON_S = 3.0
"""Time after which that scan is compared again if it has changed, seconds: its object or its mapping may have."""
_STILL_M = 0.02
_STILL_RAD = 0.035


@dataclass
class Preview:
    """Newest scan of a robot, and what is known about it.

    Attributes:
        scan: of the robot.
        scenario: of its session; None: it has no session.
        place: pose of the lidar; None: not known.
        comparison: result of the newest mirror and rotation test at this place; None: there is none yet.
        problem: reason why there is no comparison, for people; None: there is a comparison, or none is due yet.
        outlines: predicted ranges of the pose that fits best, by reading, metres; empty: not known.
        wanted: readings whose outlines pages show.
        compared_at: pose of the lidar at the newest comparison; None: there was none at this place.
        compared: scan of that comparison; None: there was none at this place.
        compared_s: time of the newest comparison, by a clock that never goes back.
    """

    scan: RobotScan
    scenario: Scenario | None = None
    place: UncertainSensorPose | None = None
    comparison: Comparison | None = None
    problem: str | None = None
    outlines: dict[Reading, tuple[float | None, ...]] = field(default_factory=dict)
    wanted: set[Reading] = field(default_factory=lambda: {AS_MEASURED})
    compared_at: UncertainSensorPose | None = None
    compared: Scan | None = None
    compared_s: float = float("-inf")


class Previews:
    """Previews of all robots, renewed by `renew`, once for all pages.

    Args:
        client: of the service.
        hub: knows the scenarios.
        clock: returns seconds that never go back.
    """

    def __init__(self, client: AsyncClient, hub: Hub, clock: Callable[[], float] = time.monotonic) -> None:
        self._client = client
        self._hub = hub
        self._clock = clock
        self._previews: dict[str, Preview] = {}
        self._scenario_of: dict[str, str] = {}

    def get(self, robot: str) -> Preview | None:
        """Return the preview of a robot; None: no scan of it is known."""
        return self._previews.get(robot)

    async def renew(self, reports: list[RobotReport]) -> None:
        """Request the newest scans of the robots in a list, and compare those of robots that have stopped.

        Raises:
            VoaClientError: the service does not respond.
        """
        robots = {report.robot: report for report in reports if report.last_scan_at is not None}
        for gone in self._previews.keys() - robots.keys():
            del self._previews[gone]
        for report in list(robots.values())[:MOST]:
            await self._renew(report)

    def forget(self, robot: str) -> None:
        """Compare the next scan of a robot again, wherever it stands."""
        preview = self._previews.get(robot)
        if preview is not None:
            preview.compared_s = float("-inf")

    async def _renew(self, report: RobotReport) -> None:
        name = report.robot
        try:
            scan = await self._client.robot_scan(name)
        except (NotFoundError, DeniedError) as error:  # none of its scans could be decoded, or the key is not for it
            if needs_key(error):
                raise
            self._previews.pop(name, None)
            return
        before = self._previews.get(name)
        scenario = await self._scenario(scan.session)
        place = place_of(scan, scenario)
        preview = before or Preview(scan)
        stands = _stands(report) or (before is not None and _is_near(preview.place, place))
        if preview.scenario is not scenario or not _is_near(preview.compared_at, place):
            preview.comparison = preview.problem = preview.compared_at = None
            preview.outlines = {}
            preview.compared_s = float("-inf")
        preview.scan, preview.scenario, preview.place = scan, scenario, place
        self._previews[name] = preview
        changed = preview.compared is None or differs(preview.compared, scan.scan)
        if stands and self._clock() - preview.compared_s >= (SOON_S if changed else AGAIN_S):
            await self._compare(preview)
        await self._predict(preview)

    async def _predict(self, preview: Preview) -> None:
        """Predict the outlines that pages show and that are not known yet."""
        comparison, scenario, place = preview.comparison, preview.scenario, preview.compared_at
        if comparison is None or scenario is None or place is None:
            return
        for reading in preview.wanted - preview.outlines.keys():
            fit = comparison.fit(reading)
            try:
                known = () if fit is None else await predicted(self._client, scenario, preview.scan, place, fit)
            except VoaClientError:  # the scan is shown without an outline
                known = ()
            preview.outlines[reading] = known

    async def _compare(self, preview: Preview) -> None:
        if preview.scenario is None or preview.place is None:
            return
        preview.compared_at, preview.compared = preview.place, preview.scan.scan
        preview.compared_s = self._clock()
        try:
            preview.comparison = await compare(self._client, preview.scenario, preview.scan, preview.place)
        except VoaClientError as error:
            preview.comparison, preview.problem = None, sentence_of(error)
        else:
            preview.problem, preview.outlines = None, {}

    async def _scenario(self, session_id: str | None) -> Scenario | None:
        """Return the scenario of a session, which never changes; None: there is no session."""
        if session_id is None:
            return None
        try:
            if session_id not in self._scenario_of:
                self._scenario_of[session_id] = (await self._client.get_session(session_id)).scenario
            return await self._hub.scenario(self._scenario_of[session_id])
        except (NotFoundError, DeniedError):  # it was deleted in the meantime, or the key is not for it
            return None


def _stands(report: RobotReport) -> bool:
    """True if the service sees that a robot stands still."""
    return bool(report.gathered) or report.waiting_for == MOVE_ON


def _is_near(one: UncertainSensorPose | None, other: UncertainSensorPose | None) -> bool:
    return one is not None and other is not None and within(one, other, _STILL_M, _STILL_RAD)
