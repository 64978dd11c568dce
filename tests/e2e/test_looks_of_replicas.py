"""Two replicas, one router, one PostgreSQL: each stop of each robot is one look, whoever is killed meanwhile.

Robots drive past stops in real time, some of them with clocks that are set back, stand, or say 0, and some with a lidar
that sends zeros at first. One replica is killed half way and started again, then the router; then some robots are
claimed for another session while they drive. Looks are compared as a set: one that the other replica takes over is
applied after the grace, when that of the next stop may be there already.
"""

import itertools
import math
import threading
import time
from collections import Counter
from collections.abc import Callable, Iterator
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import httpx2
from zenoh import CongestionControl

from tests.support.bus import Stranger, stranger
from tests.support.drives import ODOM, SCAN, START_S, Drive, Put, around, box, published, restamped, scenario
from tests.support.lidar_drivers import DRIVERS
from tests.support.postgres import Server
from tests.support.replicas import Replica, replicas
from tests.support.routers import Router, router
from tests.support.scale import scaled
from tests.support.waiting import wait_for
from voa_ros.cdr import encode_laser_scan
from voa_ros.messages import LaserScan, Stamp

ROBOTS = scaled(8, 25)
STOPS = scaled(6, 40)
"""Stops of each robot; a thousand in total at full scale."""
SESSIONS = 4
HZ = 10.0
STANDING_S, DRIVING_S = 1.6, 0.6
SPINNING_UP = 5
"""Scans of zeros, as many as a look has."""
SENTINELS = [f"sentinel_{number}" for number in range(8)]
SECONDS = 120.0
LOOK = "{ scans = 5 }"

Clock = Callable[[Stamp], Stamp]


def set_back(stamp: Stamp) -> Stamp:
    """Set the clock back by 100 s after each 5 s of driving."""
    return Stamp.of(stamp.seconds - 100.0 * ((stamp.seconds - START_S) // 5.0) + 1e5)


CLOCKS: list[Clock] = [
    lambda stamp: stamp,
    set_back,
    lambda _: Stamp(),
    lambda _: Stamp(77, 7),
    lambda stamp: Stamp.of(stamp.seconds - START_S),
]


@dataclass(frozen=True)
class Robot:
    """A robot: what it publishes in the two halves of its drive, and the session that it begins with."""

    name: str
    session: str
    drive: Drive
    halves: tuple[list[Put], list[Put]]


def spinning_up(number: int, scan: LaserScan) -> LaserScan:
    """Return zeros at first, as a lidar that spins up: a look of them is not accepted."""
    return replace(scan, ranges=(0.0,) * len(scan.ranges)) if number < SPINNING_UP else scan


def robot_of(number: int, session: str) -> Robot:
    """One of the robots, each with a phase, a clock and a lidar of its own."""
    lidar = ("lds-02", "lds-01")[number % 2]
    drive = Drive(around(STOPS + number % 3)[number % 3 :], STANDING_S, DRIVING_S)
    change = spinning_up if number % 3 == 0 else None
    clock = CLOCKS[number % len(CLOCKS)]
    puts = restamped(published(drive, DRIVERS[lidar], HZ, seed=number, change=change), clock)
    end_s = START_S + (STOPS // 2) * (STANDING_S + DRIVING_S) - 0.5 * DRIVING_S
    halves = [put for put in puts if put.at_s < end_s], [put for put in puts if put.at_s >= end_s]
    return Robot(f"robot_{number}", session, drive, halves)


class Fleet:
    """All robots, as one publisher."""

    def __init__(self, bus: Stranger) -> None:
        self._bus = bus
        self.late_s = 0.0
        """The most that a message was put after its time."""

    @contextmanager
    def publishing(self, robots: list[Robot], half: int) -> Iterator[Callable[[], float]]:
        """Publish one half of all drives in real time beside the body; yields the share that is done."""
        puts = sorted(((put, robot.name) for robot in robots for put in robot.halves[half]), key=lambda e: e[0].at_s)
        done = itertools.count(1)
        share = [0.0]

        def publish() -> None:
            began, never = time.monotonic() - puts[0][0].at_s, threading.Event()
            for put, name in puts:
                never.wait(max(0.0, put.at_s + began - time.monotonic()))
                self.late_s = max(self.late_s, time.monotonic() - put.at_s - began)
                self.put(f"{name}/{put.topic}", put.payload)
                share[0] = next(done) / len(puts)

        thread = threading.Thread(target=publish)
        thread.start()
        try:
            yield lambda: share[0]
        finally:
            thread.join()

    def put(self, key: str, payload: bytes) -> None:
        self._bus.session.put(key, payload, congestion_control=CongestionControl.BLOCK)


class Labs:
    """The replicas, and the sessions of all robots."""

    def __init__(self, both: list[Replica], mapping: Path) -> None:
        self.both = both
        object_id = httpx2.post(
            f"{both[0].url}/v1/objects", files={"file": ("box.obj", box().encode())}, timeout=SECONDS
        ).json()["id"]
        scenarios = [self.post("/v1/scenarios", scenario(object_id, lidar))["id"] for lidar in ("lds-02", "lds-01")]
        self.sessions = [self.post("/v1/sessions", {"scenario": scenarios[n % 2]})["id"] for n in range(SESSIONS)]
        self.robots = [robot_of(number, self.sessions[number % SESSIONS]) for number in range(ROBOTS)]
        place = '[robot.place]\nfrom = "odometry"\nstd = { xy_m = 0.003, yaw_rad = 0.005 }\n'
        mapping.write_text(
            "".join(
                f'[[robot]]\nname = "{robot.name}"\nscenario = "{scenarios[number % 2]}"\nlook = {LOOK}\n{place}'
                for number, robot in enumerate(self.robots)
            )
            + "".join(
                f'[[robot]]\nname = "{name}"\nsession = "{self.sessions[0]}"\nlook = {{ mode = "every" }}\n'
                'place = { from = "sensor", sensor = "E" }\n'
                for name in SENTINELS
            )
        )
        for service in both:
            wait_for(lambda own=service: len(self.reports(own)) == ROBOTS + len(SENTINELS), "the mapping", SECONDS)  # type: ignore[misc] # bound in each round, which mypy cannot infer
        for robot in self.robots:
            self.claim(robot, robot.session)

    def post(self, path: str, body: Any) -> Any:
        answer = httpx2.post(f"{self.both[1].url}{path}", json=body, timeout=SECONDS)
        assert answer.is_success, answer.text
        return answer.json()

    def claim(self, robot: Robot, session: str) -> None:
        url = f"{self.both[1].url}/v1/robots/{robot.name}/session"
        httpx2.put(url, json={"session": session}, timeout=SECONDS).raise_for_status()

    def reports(self, service: Replica) -> dict[str, Any]:
        items = httpx2.get(f"{service.url}/v1/robots", timeout=SECONDS).raise_for_status().json()["items"]
        return {each["robot"]: each for each in items if each["source"] == "ros2"}

    def places(self, session: str) -> dict[str, list[tuple[float, float]]]:
        """List the places of each robot's looks in a session, in order."""
        url = f"{self.both[1].url}/v1/sessions/{session}/history?limit=1000"
        places: dict[str, list[tuple[float, float]]] = {}
        for entry in httpx2.get(url, timeout=SECONDS).raise_for_status().json()["items"]:
            if entry["kind"] == "scan":
                request = entry["request"]
                pose = request["sensor_pose"]
                places.setdefault(request["scan"]["stamp"]["robot"], []).append((pose["x"], pose["y"]))
        return places

    def looks(self) -> int:
        return sum(len(places) for session in self.sessions for places in self.places(session).values())


def on_the_bus(both: list[Replica], bus: Stranger, mapped: list[str]) -> None:
    """Wait until both replicas are connected and subscribed."""
    for service in both:
        wait_for(lambda own=service: own.zenoh == "connected", "a replica on the bus", SECONDS)  # type: ignore[misc] # bound in each round, which mypy cannot infer
    tokens = bus.session.liveliness()
    wait_for(lambda: len(list(tokens.get(bus.keys.replica("*")))) == len(both), "both tokens", SECONDS)
    for topic in [f"{name}/{topic}" for name in mapped for topic in (SCAN, ODOM)]:
        with bus.session.declare_publisher(topic) as publisher:
            # The stub says bool; it is an object with the attribute `matching`.
            wait_for(lambda own=publisher: own.matching_status.matching, "a subscription", SECONDS)  # type: ignore[misc] # bound in each round, which mypy cannot infer


def stops_of(places: list[tuple[float, float]], drive: Drive) -> list[int]:
    """The stop at which each look was taken; fails where one was taken at none."""
    stops = []
    for x, y in places:
        near = [n for n, (at_x, at_y, _) in enumerate(drive.stops) if math.hypot(x - at_x, y - at_y) < 0.01]
        assert len(near) == 1, (x, y, near)
        stops += near
    return stops


def everything_is_worked_on(labs: Labs, fleet: Fleet) -> None:
    """Wait until both replicas have processed all that was put before, also what the other one owned.

    A look that is not accepted is refused by its owner at once, and by the other replica after all that waited longer.
    """
    degree = math.radians(1.0)
    zeros = LaserScan(Stamp(1, 1), "base_scan", 0.0, 359 * degree, degree, 0.0, 0.1, 0.1, 3.5, (0.0,) * 360)
    for name in SENTINELS:
        fleet.put(f"{name}/{SCAN}", encode_laser_scan(zeros))
    for service in labs.both:
        wait_for(lambda own=service: all(labs.reports(own)[name]["refused"] for name in SENTINELS), "it", SECONDS)  # type: ignore[misc] # bound in each round, which mypy cannot infer


def restarted(own: Router, both: list[Replica], bus: Stranger, robots: list[Robot]) -> None:
    """Restart the router, and wait until all replicas and robots are connected again."""
    own.kill()
    for service in both:
        wait_for(lambda each=service: each.zenoh == "connecting", "a replica to notice", SECONDS)  # type: ignore[misc] # bound in each round, which mypy cannot infer
    own.start()
    on_the_bus(both, bus, [robot.name for robot in robots])


def test_each_stop_is_one_look_whoever_is_killed(postgres: Server, tmp_path: Path) -> None:
    mapping = tmp_path / "robots.toml"
    mapping.write_text("")
    with ExitStack() as stack:
        own = stack.enter_context(router())
        options = ["--zenoh", own.endpoint, "--robots", str(mapping)]
        both = stack.enter_context(replicas(postgres.new_database(), tmp_path, 2, *options))
        bus = stack.enter_context(stranger(own.endpoint))
        labs, fleet = Labs(both, mapping), Fleet(bus)
        robots = labs.robots
        on_the_bus(both, bus, [robot.name for robot in robots])
        refused = bus.subscribe(bus.keys.refused("*", "*"))

        with fleet.publishing(robots, 0) as done:
            wait_for(lambda: done() > 0.4 and labs.looks() >= ROBOTS, "the first stops", SECONDS)
            both[0].kill()
            wait_for(lambda: done() > 0.6, "some stops with one replica", SECONDS)
            both[0].start()
        restarted(own, both, bus, robots)
        moved = robots[:: len(robots) // 3]
        with fleet.publishing(robots, 1) as done:
            wait_for(lambda: done() > 0.4, "some stops of the second half", SECONDS)
            for robot in moved:
                other = labs.sessions[(labs.sessions.index(robot.session) + 2) % SESSIONS]
                labs.claim(robot, other)
        everything_is_worked_on(labs, fleet)

        places = {session: labs.places(session) for session in labs.sessions}
        print(f"{labs.looks()} looks of {ROBOTS} robots; messages at most {fleet.late_s:.3f} s late")
        for robot in robots:
            stops = {session: stops_of(of.get(robot.name, []), robot.drive) for session, of in places.items()}
            if robot in moved:  # a stop at which it was moved may be one look of either session
                assert all(set(Counter(own).values()) <= {1} for own in stops.values()), (robot.name, stops)
                assert set().union(*stops.values()) == set(range(STOPS)), (robot.name, stops)
                assert len([own for own in stops.values() if own]) == 2
            else:
                assert sorted(stops[robot.session]) == list(range(STOPS)), (robot.name, stops)
                assert not any(own for session, own in stops.items() if session != robot.session)
        published = Counter(
            sample.key.rpartition("/")[2] for sample in refused if "not-accepted" in sample.json["type"]
        )
        expected = [robot.name for number, robot in enumerate(robots) if number % 3 == 0]
        assert published == Counter(expected + SENTINELS)
