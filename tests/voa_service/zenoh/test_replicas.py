"""Two replicas receive every sample: each counts once, and each refusal is published once."""

import itertools
import json
import math
import time
from collections import Counter
from collections.abc import Callable, Iterator, Sequence
from contextlib import ExitStack, contextmanager
from pathlib import Path
from typing import Any

import pytest
import zenoh

from tests.support.bus import Stranger, bridged, stranger
from tests.support.routers import Router, router
from tests.support.serving import Json, Service, data_scenario, scan_of, serving
from tests.support.waiting import wait_for
from tests.voa_service.zenoh.ros_lab import laser_scan
from voa_service.settings import Limits
from voa_service.zenoh.replicas import Replicas, owner_of
from voa_store.errors import Unavailable

GRACE_SECONDS = 0.2
MOST_BYTES = 20_000
EACH = 2
"""Number of robots for each pairing of the owner of their topics and the owner of their scans."""
MAPPING = """
[[robot]]
name = "{robot}"
session = "{session}"
look = {{ mode = "every" }}
place = {{ from = "sensor", sensor = "{sensor}" }}
"""


def owned_by_both(session: str, replicas: Sequence[str]) -> list[str]:
    """Choose names of robots, `EACH` for each pairing of the replica that owns a robot's topics, and that of its scans.

    Ids of replicas and sessions are random: of robots with given names, a replica may own none.
    """
    chosen: dict[tuple[str, str], list[str]] = {(one, other): [] for one in replicas for other in replicas}
    for number in itertools.count():
        robot = f"r{number}"
        alike = chosen[owner_of(robot, replicas), owner_of(f"{session}/{robot}", replicas)]
        if len(alike) < EACH:
            alike.append(robot)
        if all(len(each) == EACH for each in chosen.values()):
            break
    return [robot for each in chosen.values() for robot in each]


class Pair:
    """Two services on one database and one router, and robots that may put anything.

    Attributes:
        robots: names of robots, of which each service owns some, in the session that was opened last.
    """

    def __init__(self, services: list[Service], bus: Stranger, mapping: Path) -> None:
        self.services = services
        self.bus = bus
        self.scenario = services[0].create(data_scenario())
        self.robots: list[str] = []
        self._mapping = mapping
        self._beliefs = bus.subscribe(bus.keys.belief("*"))
        wait_for(self._both_are_received, "the subscription")

    def open(self) -> str:
        """Open a session, and choose its robots."""
        session = self.services[0].open(self.scenario)
        self.robots = owned_by_both(session, [service.inside.health.replica for service in self.services])
        return session

    def map(self, session: str, sensor: str) -> None:
        """Write the mapping of all robots; returns when both services follow it."""
        self._mapping.write_text("".join(MAPPING.format(robot=r, session=session, sensor=sensor) for r in self.robots))
        wait_for(lambda: all(len(self.reports(service, "ros2")) == len(self.robots) for service in self.services), "it")
        for robot in self.robots:
            with self.bus.session.declare_publisher(f"{robot}/scan") as publisher:
                wait_for(lambda: publisher.matching_status.matching, "the topic to be listened to")  # type: ignore[attr-defined] # the stub says bool; it has `matching`

    def reports(self, service: Service, source: str) -> dict[str, Json]:
        items = service.get("/v1/robots")["items"]
        return {each["robot"]: each for each in items if each["source"] == source and each["robot"] in self.robots}

    def wait_until_each_robot(self, said: Callable[[Json], bool], source: str) -> None:
        """Returns when both services say so of every robot."""

        def all_do() -> bool:
            reports = [self.reports(service, source) for service in self.services]
            return all(len(each) == len(self.robots) and all(map(said, each.values())) for each in reports)

        wait_for(all_do, "both services to say so of each robot")

    def stamps(self, session: str) -> list[Any]:
        """Stamps of the scans in the history of a session."""
        items = self.services[0].get(f"/v1/sessions/{session}/history?limit=1000")["items"]
        return [entry["request"]["scan"].get("stamp") for entry in items if entry["kind"] == "scan"]

    def applied(self, session: str) -> list[Any]:
        """Stamps of the applied scans, after all scans of the first robot were handled: they are taken in order."""
        put(self, session, self.robots[0], stamped("last"))
        wait_for(lambda: "last" in self.stamps(session), "the last scan")
        return self.stamps(session)[:-1]

    def count(self, event: str) -> list[int]:
        """Count of an event on Zenoh, for each service."""
        lines = [service.http.get("/metrics").text.splitlines() for service in self.services]
        counters = [[line for line in each if f'event="{event}"' in line and "_total" in line] for each in lines]
        return [int(float(each[0].split()[-1])) if each else 0 for each in counters]

    def flush(self) -> None:
        """Return when all that the services have put so far was received: a message put after it has arrived."""
        wait_for(lambda: not any(service.inside.health.link.state != "connected" for service in self.services), "both")
        opened = {service.open(self.scenario) for service in self.services}
        wait_for(lambda: opened <= {sample.key.rpartition("/")[2] for sample in self._beliefs}, "both")

    def _both_are_received(self) -> bool:
        for service in self.services:
            service.open(self.scenario)
        return len(self._beliefs) >= 2


@contextmanager
def paired(
    folder: Path, own: Router, grace_seconds: float = GRACE_SECONDS, first: ExitStack | None = None
) -> Iterator[Pair]:
    """Two services; the `first` one leaves the bus with that stack, if one is given."""
    mapping = folder / "robots.toml"
    mapping.write_text("")
    with ExitStack() as stack:
        limits = Limits(scan_bytes=MOST_BYTES)
        services = [stack.enter_context(serving(folder, limits=limits)) for _ in range(2)]
        for service in services:
            leaves = stack.enter_context(first) if first is not None and service is services[0] else stack
            leaves.enter_context(bridged(service, own, robots=mapping, grace_seconds=grace_seconds))
        bus = stack.enter_context(stranger(own.endpoint))
        wait_for(lambda: len(list(bus.session.liveliness().get(bus.keys.replica("*")))) == 2, "both tokens")
        yield Pair(services, bus, mapping)


@pytest.fixture(scope="module")
def pair(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Pair]:
    with router() as own, paired(tmp_path_factory.mktemp("pair"), own) as pair:
        yield pair


def put(pair: Pair, session: str, robot: str, body: Any, **how: Any) -> None:
    payload = body if isinstance(body, bytes) else json.dumps(body)
    pair.bus.session.put(
        pair.bus.keys.scan(session, robot),
        payload,
        encoding="application/json",
        congestion_control=zenoh.CongestionControl.BLOCK,
        **how,
    )


def stamped(stamp: Any) -> Json:
    """A good scan."""
    return scan_of([0.5, 0.5, None, 1.0], stamp=stamp)


def test_of_samples_at_one_time_those_that_say_the_same_count_once(pair: Pair) -> None:
    session, at = pair.open(), pair.bus.session.new_timestamp()
    for stamp in ("a", "b", "a", "c", "b"):  # as of robots whose clocks agree
        put(pair, session, pair.robots[0], stamped(stamp), timestamp=at)
    assert pair.applied(session) == ["a", "b", "c"]


def test_samples_that_say_the_same_at_two_times_count_twice(pair: Pair) -> None:
    session = pair.open()
    for at in [pair.bus.session.new_timestamp() for _ in range(2)] * 2:
        put(pair, session, pair.robots[0], stamped("a"), timestamp=at)
    assert pair.applied(session) == ["a", "a"]


def test_a_numbered_sample_is_named_by_its_publisher_and_number(pair: Pair) -> None:
    session, key = pair.open(), pair.bus.keys.scan("none", "none")
    with (
        pair.bus.session.declare_publisher(key) as one,
        pair.bus.session.declare_publisher(key) as other,
    ):
        for publisher, number, stamp in ((one, 1, "a"), (other, 1, "b"), (one, 2, "c"), (other, 1, "b"), (one, 1, "a")):
            source = zenoh.SourceInfo(publisher.id, number)
            put(pair, session, pair.robots[0], stamped(stamp), source_info=source)
    assert pair.applied(session) == ["a", "b", "c"]


def test_scans_of_every_robot_count_once_whichever_replica_owns_it(pair: Pair) -> None:
    session = pair.open()
    for robot in pair.robots:
        put(pair, session, robot, stamped(robot))
    wait_for(lambda: len(pair.stamps(session)) >= len(pair.robots), "a scan of each robot")

    def looks(service: Service) -> int:
        return sum(report["looks"] for report in pair.reports(service, "scan").values())

    wait_for(lambda: all(looks(service) for service in pair.services), "looks of each replica, which owns some")
    assert sorted(pair.stamps(session)) == sorted(pair.robots)


def test_a_replica_that_is_none_keeps_no_scan_from_being_applied(pair: Pair) -> None:
    """Anybody may declare its token; what it owns by it the others apply after their grace."""
    session = pair.open()
    with ExitStack() as stack:
        for number in range(32):
            token = pair.bus.session.liveliness().declare_token(pair.bus.keys.replica(f"forged-{number}"))
            stack.enter_context(token)
        began = time.monotonic()
        for robot in pair.robots:
            put(pair, session, robot, stamped(robot))
        wait_for(lambda: len(pair.stamps(session)) >= len(pair.robots), "every scan")
        assert time.monotonic() - began >= GRACE_SECONDS, "the forged ones own robots"
    assert sorted(pair.stamps(session)) == sorted(pair.robots)


def test_scans_without_a_name_count_once(tmp_path: Path) -> None:
    with router({"timestamping/enabled": False}) as own, paired(tmp_path, own) as pair:
        session = pair.open()
        for robot in pair.robots:
            put(pair, session, robot, stamped(robot))
        left = "scan without a name left to another replica"
        wait_for(lambda: sum(pair.count(left)) == len(pair.robots), "each scan to be left to its owner")
        assert all(pair.count(left)), "each replica owns some"
        wait_for(lambda: len(pair.stamps(session)) >= len(pair.robots), "a scan of each robot")
        assert sorted(pair.stamps(session)) == sorted(pair.robots)


@pytest.mark.parametrize(
    ("payload", "kind"),
    [
        (json.dumps(scan_of([0.5] * 4, "Q9")).encode(), "unknown-name"),
        (b'{"sensor": "Q1", "sc', "malformed-json"),
        (b'{"sensor": "' + b"a" * MOST_BYTES, "too-large"),
    ],
)
def test_a_refused_scan_is_published_once_and_both_replicas_know(pair: Pair, payload: bytes, kind: str) -> None:
    session = pair.open()
    received = pair.bus.subscribe(pair.bus.keys.refused(session, "*"))
    for robot in pair.robots:
        put(pair, session, robot, payload)

    pair.wait_until_each_robot(lambda report: str(report["last_refusal"]).startswith(f"{kind}: "), "scan")
    wait_for(lambda: {sample.key.rpartition("/")[2] for sample in received} == set(pair.robots), "each robot's problem")
    pair.flush()
    assert Counter(sample.key.rpartition("/")[2] for sample in received) == Counter(pair.robots)
    assert {sample.json["type"] for sample in received} == {f"urn:voa:problem:{kind}"}


def test_each_refusal_of_a_mapped_robot_is_published_once_and_both_replicas_know(pair: Pair) -> None:
    session = pair.open()
    received = pair.bus.subscribe(pair.bus.keys.refused(session, "*"))
    pair.map(session, "Q9")
    unreadable, of_an_unknown_place = b"\0\1\0\0 no scan", laser_scan((0.5, 0.5, math.inf, 1.0), 100.0)
    for number, payload in enumerate((unreadable, of_an_unknown_place), start=1):
        for robot in pair.robots:
            pair.bus.session.put(f"{robot}/scan", payload)
        pair.wait_until_each_robot(lambda report, number=number: report["refused"] == number, "ros2")  # type: ignore[misc] # bound in each round, which mypy cannot infer
        wait_for(lambda number=number: len(received) >= number * len(pair.robots), "every robot's problem")  # type: ignore[misc] # bound in each round, which mypy cannot infer
        pair.flush()
        assert Counter(sample.key.rpartition("/")[2] for sample in received) == Counter(pair.robots * number)


def test_a_replica_that_joins_again_knows_those_that_are_there() -> None:
    robots = [f"r{number}" for number in range(8)]
    with router() as own, stranger(own.endpoint) as other:
        one, two = Replicas("one", other.keys), Replicas("two", other.keys)

        @contextmanager
        def joined() -> Iterator[None]:
            with stranger(own.endpoint) as bus, one.on(bus.session):
                yield

        with two.on(other.session):
            for _ in range(2):
                with joined():
                    wait_for(lambda: all(one.owns(robot) != two.owns(robot) for robot in robots), "one owner of each")
                    assert any(two.owns(robot) for robot in robots)
                wait_for(lambda: all(two.owns(robot) for robot in robots), "the one to be gone")
        wait_for(lambda: not list(other.session.liveliness().get(other.keys.replica("*"))), "both to be gone")
        with joined():
            wait_for(lambda: all(one.owns(robot) for robot in robots), "one owner of all")


def refusing(*_: Any) -> Any:
    raise Unavailable("the database does not answer")


def received(service: Service, source: str) -> int:
    """Number of scans that a service has received, those that wait for another replica included."""
    if source == "ros2":
        return sum(each["scans"] for each in service.get("/v1/robots")["items"] if each["source"] == source)
    lines = service.http.get("/metrics").text.splitlines()
    return sum(
        int(float(line.split()[-1])) for line in lines if 'event="scan received"' in line and "_created" not in line
    )


@pytest.mark.parametrize("source", ["ros2", "scan"])
@pytest.mark.parametrize("failing", [0, 1], ids=["the-one-that-leaves-fails", "the-other-one-fails"])
def test_what_waits_for_another_replica_is_applied_at_once_when_either_leaves(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, source: str, failing: int
) -> None:
    first, endless = ExitStack(), 1_000.0
    with router() as own, paired(tmp_path, own, endless, first) as pair:
        session = pair.open()
        pair.map(session, "Q1")
        failing_one, other = pair.services[failing], pair.services[1 - failing]
        monkeypatch.setattr(failing_one.inside.sessions.store, "change", refusing)
        before = received(other, source)
        for robot in pair.robots:
            if source == "ros2":
                pair.bus.session.put(f"{robot}/scan", laser_scan((0.5, 0.5, math.inf, 1.0), 100.0))
            else:
                put(pair, session, robot, stamped(robot))
        wait_for(lambda: received(other, source) == before + len(pair.robots), "all")
        wait_for(lambda: any(each["refused"] for each in pair.reports(failing_one, source).values()), "its own")
        first.close()
        wait_for(lambda: len(pair.stamps(session)) == len(pair.robots), "all scans")
