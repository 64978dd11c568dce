"""ROS 2 topics through the router: latched ones, and those that pass a router of the robot's own, as rmw_zenoh has."""

import json
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

import pytest
import zenoh
from zenoh.ext import CacheConfig, declare_advanced_publisher
from zenoh.handlers import Callback

from tests.support.lab_router import LabRouter, lab_router, noting, opened
from tests.support.routers import Router, router
from tests.support.waiting import wait_for
from voa_msgs.links import session_config
from voa_ros.latched import declare_latched_subscriber

ROOT = "voa/v1/lab7"
POSE = "tb3_1/amcl_pose"


@pytest.fixture(scope="module")
def lab(tmp_path_factory: pytest.TempPathFactory) -> Iterator[LabRouter]:
    """Certificates alone: a router that logs in by a password would want one of its own nodes, too."""
    with lab_router(tmp_path_factory.mktemp("lab"), "certificates") as running:
        yield running


@contextmanager
def publishing(lab: LabRouter, name: str) -> Iterator[zenoh.Session]:
    """Join as a robot whose samples have time stamps, as those of advanced publishers must."""
    with opened(lab.entries_of(name) | {"timestamping/enabled": True}) as session:
        yield session


def keep(session: zenoh.Session, key: str) -> Any:
    """Publish a pose on a latched topic."""
    publisher = declare_advanced_publisher(session, key, cache=CacheConfig(max_samples=1), publisher_detection=True)
    publisher.put(b"the pose")
    return publisher


def listening(session: zenoh.Session, expression: str, *, latched: bool = False) -> list[str]:
    """Subscribe for the rest of the session; returns the list to which the keys of samples are added."""
    seen: list[str] = []
    receive = noting(seen)
    declare = declare_latched_subscriber if latched else zenoh.Session.declare_subscriber
    declare(session, expression, receive)
    return seen


@pytest.mark.parametrize(("who", "expression"), [("service", POSE), ("recorder", POSE), ("recorder", "tb3_1/**")])
def test_the_newest_sample_of_a_latched_topic_reaches_a_late_subscriber(
    lab: LabRouter, who: str, expression: str
) -> None:
    with publishing(lab, "tb3_1") as robot, lab.joined(who) as late:
        kept = keep(robot, POSE)
        seen = listening(late, expression, latched=True)
        wait_for(lambda: POSE in seen, "the sample that was published before", 10.0)
        kept.undeclare()


def test_no_client_may_keep_samples_for_another(lab: LabRouter, observing: zenoh.Session) -> None:
    with publishing(lab, "tb3_2") as other:
        kept = [keep(other, key) for key in (POSE, "tb3_2/amcl_pose")]
        seen = listening(observing, "*/amcl_pose", latched=True)
        wait_for(lambda: "tb3_2/amcl_pose" in seen, "the robot's own sample", 10.0)
        assert POSE not in seen
        for publisher in kept:
            publisher.undeclare()


@contextmanager
def robots_own(lab: LabRouter, name: str) -> Iterator[Router]:
    """A router on a robot, which joins the lab's router as the robot; its own clients need no login."""
    entries = lab.entries_of(name)
    more = {"connect/endpoints": entries["connect"]["endpoints"], "transport/link/tls": entries["transport/link/tls"]}
    with router(more) as own:
        yield own


@contextmanager
def inside(own: Router) -> Iterator[zenoh.Session]:
    config = zenoh.Config()
    for path, value in session_config([own.endpoint]).items():
        config.insert_json5(path, json.dumps(value))
    with zenoh.open(config) as session:
        yield session


def test_a_router_of_the_robots_own_is_held_to_the_robots_rules(lab: LabRouter, observing: zenoh.Session) -> None:
    seen = listening(observing, "**")
    with lab.joined("service") as service, robots_own(lab, "tb3_1") as own, inside(own) as node:
        wait_for(lambda: _is_linked(service, node), "the link of both routers", 10.0)
        scans = listening(service, f"{ROOT}/scan/*/*")
        topics = listening(service, "0/tb3_1/scan/*/*")
        beliefs = listening(node, f"{ROOT}/belief/*")

        def arrived() -> bool:
            node.put(f"{ROOT}/belief/s1", b"forged")
            node.put(f"{ROOT}/scan/s1/tb3_2", b"of another")
            node.put(f"{ROOT}/scan/s1/tb3_1", b"own")
            node.put("0/tb3_1/scan/t/h", b"own")
            service.put(f"{ROOT}/belief/s2", b"true")
            return bool(scans and topics and f"{ROOT}/belief/s2" in beliefs)

        wait_for(arrived, "samples both ways", 10.0)
        assert set(scans) == {f"{ROOT}/scan/s1/tb3_1"}
        assert not {f"{ROOT}/belief/s1", f"{ROOT}/scan/s1/tb3_2"} & set(seen)


def test_a_node_behind_the_robots_router_calls_the_service_and_cannot_pose_as_it(lab: LabRouter) -> None:
    with lab.joined("service") as service, robots_own(lab, "tb3_1") as own, inside(own) as node:
        key = f"{ROOT}/rpc/session.get"
        wait_for(lambda: _is_linked(service, node), "the link of both routers", 10.0)
        with responder(service, f"{ROOT}/rpc/*", b"of the service"), lab.joined("console") as console:
            wait_for(lambda: _replies(node, key) == [b"of the service"], "the service to answer the node", 10.0)
            with responder(node, f"{ROOT}/rpc/*", b"forged"), responder(node, "marker/own", b"own"):
                wait_for(lambda: _replies(console, "marker/own"), "the node's queryables", 10.0)
                assert _replies(console, key) == [b"of the service"]


def _is_linked(service: zenoh.Session, node: zenoh.Session) -> bool:
    """Declare a queryable, and return True if the node reaches it.

    Zenoh 1.10.2 with an access list, whatever its rules, may not pass on what is declared while routers link.
    """
    with responder(service, "marker/link", b"x"):
        return any(_replies(node, "marker/link") for _ in range(50))


def responder(session: zenoh.Session, key: str, text: bytes) -> Any:
    def answer(query: zenoh.Query) -> None:
        with query:
            query.reply(query.key_expr, text)

    return session.declare_queryable(key, Callback(answer, indirect=False), complete=True)


def _replies(session: zenoh.Session, key: str) -> list[bytes]:
    """Return the replies of all queryables."""

    replies = session.get(key, target=zenoh.QueryTarget.ALL, consolidation=zenoh.ConsolidationMode.NONE, timeout=5.0)
    return [reply.ok.payload.to_bytes() for reply in replies if reply.ok is not None]
