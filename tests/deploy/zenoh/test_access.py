"""Every row of the access list against a real router: allowed, and refused, whichever way clients log in."""

import itertools
from dataclasses import dataclass, field
from typing import Any

import pytest
import zenoh
from zenoh.handlers import Callback

from tests.support.lab_router import LabRouter, noting
from tests.support.waiting import wait_for

ROOT = "voa/v1/lab7"
TOKEN = "@ros2_lv/0/aa/0/10/MP/%/%tb3_1/lidar/%tb3_1%scan/t/h/q"  # noqa: S105 - of liveliness
BRIDGE = "@/aa/@ros2_lv/MP/tb3_1§scan/sensor_msgs§msg§LaserScan/q"
SECONDS = 10.0
numbers = itertools.count()


@dataclass
class Observer:
    """Session that the router allows everything, with the keys of all samples that it has received."""

    session: zenoh.Session
    seen: list[str] = field(default_factory=list)


@pytest.fixture
def observer(observing: zenoh.Session) -> Observer:
    return Observer(observing)


def marker() -> str:
    return f"marker/{next(numbers)}"


def passes(client: zenoh.Session, observer: Observer, key: str, *, declared: bool = False) -> bool:
    """Put on a key, and return True if the router lets it pass; `declared`: by a declared publisher."""
    last, receive = marker(), noting(observer.seen)

    def arrived(name: str) -> bool:
        client.put(f"{last}/{name}", b"x")
        return f"{last}/{name}" in observer.seen

    with (
        observer.session.declare_subscriber(f"{key.rpartition('/')[0]}/*" if "/" in key else key, receive),
        observer.session.declare_subscriber(f"{last}/*", receive),
    ):
        wait_for(lambda: arrived("ready"), "the subscriptions", SECONDS)
        if declared:
            with client.declare_publisher(f"{last}/x") as known, client.declare_publisher(key) as publisher:
                status: Any = known  # Zenoh's stub takes the status for a bool
                wait_for(lambda: status.matching_status.matching, "the subscription to reach the publisher", SECONDS)
                publisher.put(b"x")
        else:
            client.put(key, b"x")
        wait_for(lambda: arrived("end"), "the marker", SECONDS)
    return key in observer.seen


def receives(client: zenoh.Session, observer: Observer, expression: str, key: str) -> bool:
    """Subscribe to a key expression, and return True if a sample on the key arrives."""
    last = marker()
    seen: list[str] = []
    receive = noting(seen)
    with client.declare_subscriber(expression, receive), client.declare_subscriber(f"{last}/*", receive):

        def arrived(name: str) -> bool:
            observer.session.put(f"{last}/{name}", b"x")
            return f"{last}/{name}" in seen

        wait_for(lambda: arrived("ready"), "the subscription", SECONDS)
        observer.session.put(key, b"x")
        wait_for(lambda: arrived("end"), "the marker", SECONDS)
    return key in seen


def answered(client: zenoh.Session, key: str) -> bool:
    return any(reply.ok is not None for reply in client.get(key, payload=b"{}", timeout=5.0))


def responder(session: zenoh.Session, key: str) -> Any:
    def answer(query: zenoh.Query) -> None:
        with query:
            query.reply(query.key_expr, b"{}")

    return session.declare_queryable(key, Callback(answer, indirect=False), complete=True)


def answers(client: zenoh.Session, observer: Observer, key: str) -> bool:
    """Declare a queryable, and return True if a query reaches it and its reply passes."""
    last = marker()
    with responder(client, key), responder(client, last):
        wait_for(lambda: answered(observer.session, last), "the queryable of the marker", SECONDS)
        return answered(observer.session, key)


def announces(client: zenoh.Session, observer: Observer, key: str) -> bool:
    """Declare a liveliness token, and return True if another client sees it."""
    last, liveliness = marker(), client.liveliness()
    with liveliness.declare_token(key), liveliness.declare_token(last):
        wait_for(lambda: alive(observer.session, last), "the token of the marker", SECONDS)
        return alive(observer.session, key)


def alive(client: zenoh.Session, expression: str) -> bool:
    return any(reply.ok is not None for reply in client.liveliness().get(expression, timeout=5.0))


SCAN, BELIEF, REFUSED = f"{ROOT}/scan/s1/", f"{ROOT}/belief/s1", f"{ROOT}/refused/s1/"
PUTS = [
    ("tb3_1", f"{SCAN}tb3_1", True),
    ("tb3_1", f"{SCAN}tb3_2", False),
    ("tb3_2", f"{SCAN}tb3_1", False),
    ("ur5e", f"{SCAN}tb3_1", False),
    ("ur5e", f"{SCAN}ur5e", False),
    ("console", f"{SCAN}console", False),
    ("recorder", f"{SCAN}tb3_1", False),
    ("tb3_1", f"{ROOT}/elsewhere/s1", False),
    ("tb3_1", f"{SCAN}tb3_1/more", False),
    *((who, BELIEF, who == "service") for who in ("service", "tb3_1", "ur5e", "console", "rviz")),
    *((who, f"{REFUSED}tb3_1", who == "service") for who in ("service", "tb3_1", "ur5e", "console", "rviz")),
    *((who, f"{ROOT}/replica/x", False) for who in ("service", "tb3_1", "ur5e", "console")),
    *((who, f"{ROOT}/rpc/session.get", False) for who in ("service", "tb3_1", "ur5e", "console")),
    ("tb3_1", "tb3_1/scan", True),
    ("tb3_1", "0/tb3_1/scan/t/h", True),
    ("tb3_1", "7/tb3_1/scan/t/h", False),
    ("tb3_2", "7/tb3_2/scan/t/h", True),
    ("tb3_2", "tb3_1/scan", False),
    ("tb3_2", "0/tb3_1/scan/t/h", False),
    ("tb3_1", "tb3_1/voa/outcome", True),
    ("tb3_1", "tb3_1/voa/belief", False),
    ("tb3_1", "tb3_1/voa/numbers/fit_rmsd_mm", False),
    ("tb3_1", "0/tb3_1/voa/belief/t/h", False),
    ("tb3_1", "initialpose", False),
    ("ur5e", "tb3_1/cmd_vel", False),
    ("console", "tb3_1/cmd_vel", False),
    ("recorder", "tb3_1/cmd_vel", False),
    ("rviz", "initialpose", True),
    ("rviz", "0/initialpose/t/h", True),
    ("service", "tb3_1/voa/belief", True),
    ("service", "7/tb3_2/voa/numbers/fit_rmsd_mm/t/h", True),
    ("service", "goal_pose", True),
    ("service", "tb3_1/cmd_vel", False),
    ("service", "initialpose", False),
    ("service", f"{SCAN}tb3_1", False),
]


@pytest.mark.parametrize(("who", "key", "allowed"), PUTS)
def test_who_may_put(lab: LabRouter, observer: Observer, who: str, key: str, allowed: bool) -> None:
    with lab.joined(who) as client:
        assert passes(client, observer, key) is allowed
        observer.seen.clear()
        assert passes(client, observer, key, declared=True) is allowed


SUBSCRIPTIONS = [
    ("service", f"{ROOT}/scan/*/*", f"{SCAN}tb3_1", True),
    ("service", "tb3_1/scan", "tb3_1/scan", True),
    ("service", "0/tb3_1/scan/*/*", "0/tb3_1/scan/t/h", True),
    ("service", "7/tb3_2/scan/*/*", "7/tb3_2/scan/t/h", True),
    *((who, f"{ROOT}/belief/*", BELIEF, True) for who in ("service", "tb3_1", "ur5e", "console", "recorder")),
    ("tb3_1", BELIEF, BELIEF, True),
    ("tb3_1", f"{REFUSED}tb3_1", f"{REFUSED}tb3_1", True),
    ("tb3_1", f"{REFUSED}tb3_2", f"{REFUSED}tb3_2", False),
    ("ur5e", f"{REFUSED}tb3_1", f"{REFUSED}tb3_1", False),
    ("console", f"{ROOT}/refused/*/*", f"{REFUSED}tb3_1", True),
    ("recorder", f"{ROOT}/scan/*/*", f"{SCAN}tb3_1", True),  # its `scans` are true
    *((who, f"{ROOT}/scan/*/*", f"{SCAN}tb3_1", False) for who in ("console", "rviz", "ur5e", "tb3_1")),
    ("console", f"{SCAN}tb3_1", f"{SCAN}tb3_1", False),
    ("console", f"{ROOT}/*/*/tb3_1", f"{SCAN}tb3_1", False),
    ("tb3_2", f"{SCAN}tb3_1", f"{SCAN}tb3_1", False),
    ("ur5e", f"{SCAN}tb3_1", f"{SCAN}tb3_1", False),
    ("tb3_2", "tb3_1/scan", "tb3_1/scan", False),
    ("tb3_1", "tb3_1/cmd_vel", "tb3_1/cmd_vel", True),
    ("tb3_2", "tb3_2/cmd_vel", "tb3_2/cmd_vel", False),
    ("tb3_1", "tb3_1/voa/belief", "tb3_1/voa/belief", True),
    ("tb3_1", "tb3_2/voa/belief", "tb3_2/voa/belief", False),
    ("console", "tb3_1/scan", "tb3_1/scan", False),
    ("recorder", "tb3_1/**", "tb3_1/camera/image", True),
    ("recorder", "0/tb3_1/**", "0/tb3_1/scan/t/h", True),
    ("recorder", "*/tb3_1/*/*/**", "0/tb3_1/scan/t/h", True),
    ("recorder", "*/tb3_1/*/*/**", "7/tb3_1/scan/t/h", True),
    ("recorder", "tb3_2/**", "tb3_2/scan", False),
    ("recorder", "*/tb3_2/**", "7/tb3_2/scan/t/h", False),
    ("rviz", "initialpose", "initialpose", False),
    ("console", "**", BELIEF, False),  # a subscription that is too wide is refused as a whole
]


@pytest.mark.parametrize(("who", "expression", "key", "allowed"), SUBSCRIPTIONS)
def test_who_may_subscribe(
    lab: LabRouter, observer: Observer, who: str, expression: str, key: str, allowed: bool
) -> None:
    with lab.joined(who) as client:
        assert receives(client, observer, expression, key) is allowed


QUERIES = [
    *((who, method, True) for who in ("tb3_1", "ur5e") for method in ("session.get", "scan.apply", "outcome.report")),
    *(("console", method, True) for method in ("session.get", "history.get", "voa.rank", "robot.list", "object.mesh")),
    *(("console", method, False) for method in ("session.create", "belief.put", "scan.apply", "look.announce")),
    *(("recorder", method, method == "session.get") for method in ("session.get", "outcome.report", "robot.look")),
    ("service", "session.get", False),
]


@pytest.mark.parametrize(("who", "method", "allowed"), QUERIES)
def test_who_may_call(lab: LabRouter, observer: Observer, who: str, method: str, allowed: bool) -> None:
    with lab.joined("service") as service, responder(service, f"{ROOT}/rpc/*"):
        wait_for(lambda: answered(observer.session, f"{ROOT}/rpc/ready"), "the queryable of the service", SECONDS)
        with lab.joined(who) as client:
            assert answered(client, f"{ROOT}/rpc/{method}") is allowed


@pytest.mark.parametrize("key", [f"{ROOT}/rpc/session.get", f"{ROOT}/rpc/*", f"{ROOT}/belief/s1"])
@pytest.mark.parametrize("who", ["service", "tb3_1", "ur5e", "console", "recorder", "rviz"])
def test_only_the_service_answers(lab: LabRouter, observer: Observer, who: str, key: str) -> None:
    with lab.joined(who) as client:
        assert answers(client, observer, key) is (who == "service" and "/rpc/" in key)


TOKENS = [
    *((who, f"{ROOT}/replica/x", who == "service") for who in ("service", "tb3_1", "ur5e", "console", "rviz")),
    *((who, TOKEN, who == "tb3_1") for who in ("tb3_1", "ur5e", "console", "service")),
    *((who, BRIDGE, who == "tb3_1") for who in ("tb3_1", "ur5e", "console", "service")),
]


@pytest.mark.parametrize(("who", "key", "allowed"), TOKENS)
def test_who_may_have_a_liveliness_token(lab: LabRouter, observer: Observer, who: str, key: str, allowed: bool) -> None:
    with lab.joined(who) as client:
        assert announces(client, observer, key) is allowed


SEES = [
    *((who, f"{ROOT}/replica/*", True) for who in ("service", "tb3_1", "ur5e", "console")),
    *((who, f"{ROOT}/other/*", False) for who in ("service", "tb3_1", "console")),
    *((who, "@ros2_lv/**", who == "recorder") for who in ("recorder", "tb3_2", "ur5e", "console")),
]


@pytest.mark.parametrize(("who", "expression", "allowed"), SEES)
def test_who_may_see_liveliness_tokens(
    lab: LabRouter, observer: Observer, who: str, expression: str, allowed: bool
) -> None:
    token, liveliness = expression.replace("/**", "/x").replace("*", "x"), observer.session.liveliness()
    with liveliness.declare_token(token), lab.joined(who) as client:
        wait_for(lambda: alive(observer.session, token), "the token", SECONDS)
        assert alive(client, expression) is allowed
        seen: list[str] = []
        note = noting(seen)
        last = marker()
        with (
            client.liveliness().declare_subscriber(expression, note, history=True),
            client.liveliness().declare_subscriber(last, note, history=True),
            liveliness.declare_token(last),
        ):
            wait_for(lambda: last in seen, "the token of the marker", SECONDS)
        assert (token in seen) is allowed
