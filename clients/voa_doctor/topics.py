"""Checks of mapped ROS 2 topics: messages arrive, and are as the mapping expects."""

from collections.abc import Iterator, Sequence
from contextlib import ExitStack
from dataclasses import dataclass, replace
from typing import Any

import zenoh
from zenoh.handlers import Callback

from voa_doctor.findings import Budget, Finding
from voa_doctor.messages import judged, other_domains
from voa_doctor.over_zenoh import alive
from voa_doctor.samples import Sample, Samples
from voa_ros.latched import declare_latched_subscriber
from voa_ros.robots import RobotMapping, Subscription
from voa_ros.topics import POSE_WITH_COVARIANCE_STAMPED

_SEVERAL = 8
"""Number of messages of a topic that is enough to check stamps and frames."""
_RMW_PUBLISHERS = "@ros2_lv/**"
_BRIDGES_PUBLISHERS = "@/*/@ros2_lv/**"


@dataclass(frozen=True)
class Listening:
    """Topics to subscribe to, and for how long.

    Attributes:
        robots: the mapping.
        seconds: longest time to wait for messages.
        most_beams: largest number of beams that the service accepts.
    """

    robots: Sequence[RobotMapping]
    seconds: float
    most_beams: int


def check_topics(session: zenoh.Session, listening: Listening, budget: Budget) -> Iterator[Finding]:
    """Subscribe to all topics of a mapping at once, and check the messages.

    Args:
        session: with the router.
        listening: topics, and for how long.
        budget: time that is left.
    """
    wanted = [(robot, each) for robot in listening.robots for each in robot.subscriptions]
    samples = Samples()
    with ExitStack() as stack:
        for each in {each.topic: each for _, each in wanted}.values():
            for expression in (each.topic, f"*/{each.topic}/*/*"):  # in any domain, to report a wrong one
                receive = Callback(samples.receiver(each.topic), indirect=False)
                stack.callback(_declare(session, each, expression, receive).undeclare)
        counts = {each.topic: 1 if each.type == POSE_WITH_COVARIANCE_STAMPED else _SEVERAL for _, each in wanted}
        received = samples.wait(counts, budget.step(listening.seconds))
    published = _published(session, budget) if any(each.topic not in received for _, each in wanted) else []
    for robot, each in wanted:
        check = f"{robot.name} /{each.topic}"
        of_topic = received.get(each.topic, [])
        ours = [sample for sample in of_topic if sample.domain in (None, robot.domain)]
        if ours:
            finding = judged(check, robot, each, ours, listening.most_beams)
            yield replace(finding, seen=finding.seen + other_domains(of_topic, ours))
        elif of_topic:
            yield _other_domain(check, robot, of_topic)
        else:
            yield _silent(check, each, published, listening.seconds)


def _declare(session: zenoh.Session, each: Subscription, expression: str, receive: "Callback[zenoh.Sample]") -> Any:
    if each.type == POSE_WITH_COVARIANCE_STAMPED:
        return declare_latched_subscriber(session, expression, receive)
    return session.declare_subscriber(expression, receive)


def _published(session: zenoh.Session, budget: Budget) -> list[str]:
    """Return the topics that ROS 2 nodes announce, as far as the router lets this user see it."""
    topics: list[str] = []
    for key in alive(session, _RMW_PUBLISHERS, budget):
        chunks = key.split("/")
        if "MP" in chunks:
            topics += [chunk.strip("%").replace("%", "/") for chunk in chunks if chunk.startswith("%") and chunk != "%"]
    for key in alive(session, _BRIDGES_PUBLISHERS, budget):
        _, _, announced = key.partition("/@ros2_lv/MP/")
        if announced:
            topics.append(announced.split("/")[0].replace("§", "/").strip("/"))
    return sorted(set(topics))


def _other_domain(check: str, robot: RobotMapping, samples: list[Sample]) -> Finding:
    domains = sorted({sample.domain for sample in samples if sample.domain is not None})
    listed = " and ".join(str(domain) for domain in domains)
    seen = f"messages arrive in ROS domain {listed} only, but the mapping says {robot.domain}"
    return Finding(check, "wrong", seen, f"set domain = {domains[0]} for this robot in the mapping")


def _silent(check: str, each: Subscription, published: list[str], listen_s: float) -> Finding:
    seen = f"no message within {listen_s:g} s"
    if each.topic in published:
        seen += ", although a node announces that it publishes it"
        if each.type == POSE_WITH_COVARIANCE_STAMPED:
            advice = "give AMCL its initial pose (RViz: 2D Pose Estimate), or drive 0.3 m: it has not published yet"
            return Finding(check, "wrong", seen, advice)
        return Finding(
            check,
            "wrong",
            seen,
            "check that the sensor is on, and that `ros2 topic hz` shows messages on the robot itself",
        )
    if published:
        seen += f"; published are {', '.join(f'/{topic}' for topic in published[:8])}"
        return Finding(check, "wrong", seen, "check namespace and topic in the mapping")
    advice = (
        "check that the robot is on, its bridge or rmw_zenoh connected to this router, ROS_DOMAIN_ID, and namespace"
    )
    return Finding(check, "wrong", seen, advice)
