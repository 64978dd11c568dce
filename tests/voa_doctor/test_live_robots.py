"""A robot of a real service with one mistake after the other: `voa doctor` reports each while it is there."""

import json
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path

import pytest

from tests.support.routers import Router, router
from tests.support.serving import data_scenario
from tests.support.waiting import wait_for
from tests.voa_cli.labs import Lab, service_on
from tests.voa_doctor.examinations import Findings, examined, wrong
from tests.voa_doctor.publishing import publishing, scan, sent
from voa_client import Client, ZenohAddress
from voa_client.zenoh_session import joined
from voa_msgs.keys import Keys
from voa_msgs.robots import RobotReport
from voa_msgs.scenarios import ScenarioRequest
from voa_msgs.sessions import SessionRequest
from voa_ros.messages import LaserScan

GOOD, BLIND = (0.5, 0.5, 1.0, 1.0), (0.0, 0.0, 0.0, 0.0)
ROBOT, TOPIC = "robot tb3_1", "tb3_1 /tb3_1/scan"


@dataclass
class Robot:
    """A robot with a lidar of four beams, its service, and the file that maps it.

    Attributes:
        ranges: of its scans from now on.
    """

    client: Client
    lab: Lab
    mapping: Path
    scenario: str
    ranges: Sequence[float] = GOOD

    def map(self, more: str = "look = { mode = 'stationary', scans = 2 }") -> None:
        """Write the mapping."""
        place = 'place = { from = "sensor", sensor = "Q1" }'
        self.mapping.write_text(f'[[robot]]\nname = "tb3_1"\nscenario = "{self.scenario}"\n{place}\n{more}\n')

    def become(self, ranges: Sequence[float]) -> None:
        """Let its scans be others; returns when the service has received more than a look of them."""
        self.ranges = ranges
        (report,) = self.client.robots().items
        self.wait(lambda now: now.scans > report.scans + 5, "scans")

    def wait(self, condition: Callable[[RobotReport], object], what: str) -> None:
        """Wait for a report of it."""
        wait_for(lambda: any(condition(each) for each in self.client.robots().items if each.robot == "tb3_1"), what)

    def examined(self, capsys: pytest.CaptureFixture[str]) -> Findings:
        """Findings of the doctor now."""
        where = ["--url", self.lab.url, "--zenoh", self.lab.endpoint, "--robots", str(self.mapping)]
        return examined(capsys, *where)[1]


@pytest.fixture(scope="module")
def live_router() -> Iterator[Router]:
    """A router apart from that of the other tests, whose service would receive these scans too."""
    with router() as own:
        yield own


@pytest.fixture
def robot(live_router: Router, tmp_path: Path) -> Iterator[Robot]:
    mapping = tmp_path / "robots.toml"
    mapping.write_text("")
    with service_on(live_router, tmp_path, ["--robots", str(mapping)]) as lab, Client(lab.url) as client:
        scenario = client.create_scenario(ScenarioRequest.model_validate(data_scenario())).id
        own = Robot(client, lab, mapping, scenario)
        with driving(own, live_router):
            yield own


@contextmanager
def driving(own: Robot, router: Router) -> Iterator[None]:
    def seen(step: int) -> LaserScan:
        return scan(step, ranges=tuple(own.ranges), angle_increment=0.1, angle_max=0.3, range_max=2.0)

    with publishing(router, sent("tb3_1/scan", seen)):
        yield


def test_a_robot_from_one_fault_to_the_next(robot: Robot, capsys: pytest.CaptureFixture[str]) -> None:
    robot.map()
    robot.wait(lambda report: report.refused, "scans without a session are refused")
    result = robot.examined(capsys)
    assert result[TOPIC]["state"] == "ok"
    assert "waits for a session on scenario" in wrong(result)[ROBOT]
    assert "claim the robot" in result[ROBOT]["advice"]

    robot.become(BLIND)
    robot.client.create_session(SessionRequest(scenario=robot.scenario))
    robot.wait(lambda report: report.last_look is not None, "a look")
    result = robot.examined(capsys)
    assert "no beam of 8 scans measures a distance" in wrong(result)[TOPIC]
    assert "s ago at sensor 'Q1', was not accepted: the belief is unchanged, no_beams" in wrong(result)[ROBOT]
    assert "check that the lidar turns" in result[ROBOT]["advice"]

    robot.become(GOOD)
    robot.wait(lambda report: report.last_look is not None and report.last_look.accepted, "a look that counts")
    result = robot.examined(capsys)
    assert result[ROBOT]["state"] == "ok"
    assert "waits for the robot to move on" in result[ROBOT]["seen"]

    robot.map('frame_id = "front"')
    robot.wait(lambda report: (report.waiting_for or "").startswith("a scan of frame"), "the frame to be missed")
    result = robot.examined(capsys)
    assert "the mapping says 'front'" in wrong(result)[TOPIC]
    assert "waits for a scan of frame 'front': found 'base_scan'" in wrong(result)[ROBOT]

    robot.map("look = { mode = 'every' }")
    robot.wait(lambda report: "every-while-parked" in [each.kind for each in report.warnings], "the warning")
    result = robot.examined(capsys)
    assert result[f"{ROBOT}: every-while-parked"]["state"] == "warning"

    robot.mapping.write_text("[[robot]")
    wait_for(lambda: robot.client.robots().mapping_error, "the mapping to be read")
    result = examined(capsys, "--url", robot.lab.url)[1]
    assert "robots.toml: expected TOML" in wrong(result)["mapping"]


def test_a_robot_whose_raw_scans_are_refused(
    capsys: pytest.CaptureFixture[str], live_router: Router, tmp_path: Path
) -> None:
    with (
        service_on(live_router, tmp_path) as lab,
        Client(lab.url) as client,
        joined(ZenohAddress.parse(lab.endpoint)) as robot,
    ):
        scenario = client.create_scenario(ScenarioRequest.model_validate(data_scenario()))
        session = client.create_session(SessionRequest(scenario=scenario.id)).id
        robot.put(Keys().scan(session, "clumsy"), json.dumps({"ranges": 3}))
        wait_for(lambda: any(each.refused for each in client.robots().items), "the service refuses it")
        code, result = examined(capsys, "--url", lab.url, "--zenoh", lab.endpoint)
        assert code == 1
        assert "1 scan, 0 looks, 1 refused" in wrong(result)["robot clumsy"]
