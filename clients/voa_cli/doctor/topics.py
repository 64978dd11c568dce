"""Mapped ROS 2 topics: does anything come, and is it what it should be."""

import threading
import time
from collections.abc import Callable, Iterator, Sequence
from contextlib import ExitStack
from dataclasses import dataclass
from typing import Any

import zenoh
from zenoh.handlers import Callback

from voa_cli.doctor.findings import Budget, Finding
from voa_cli.doctor.over_http import CLOCK_S
from voa_cli.doctor.over_zenoh import alive
from voa_ros.cdr import InvalidCdr, decode_laser_scan, decode_odometry, decode_pose
from voa_ros.messages import LaserScan, Odometry, PoseWithCovariance
from voa_ros.robots import RobotMapping, Subscription
from voa_ros.topics import LASER_SCAN, ODOMETRY, expressions, met

_TRAVELS_S = 0.5
"""A scan is stamped at the beginning of its revolution of 0.2 s, or at its end, and travels."""
_RMW_PUBLISHERS = "@ros2_lv/**"
_BRIDGES_PUBLISHERS = "@/*/@ros2_lv/**"


@dataclass(frozen=True)
class _Sample:
    payload: bytes
    at_s: float
    type_name: str | None
    """As its key says; None: the key does not say."""


class _First:
    """The first sample of each topic."""

    def __init__(self) -> None:
        self._samples: dict[str, _Sample] = {}
        self._changed = threading.Condition()

    def hearer(self, topic: str) -> Callable[[zenoh.Sample], None]:
        """A callback for one topic's subscribers."""

        def hear(sample: zenoh.Sample) -> None:
            told = met(topic, str(sample.key_expr))
            with self._changed:
                if told is not None and topic not in self._samples:
                    self._samples[topic] = _Sample(sample.payload.to_bytes(), time.time(), told.type_name)
                    self._changed.notify_all()

        return hear

    def wait(self, topics: Sequence[str], seconds: float) -> dict[str, _Sample]:
        """What has come, when all have, or the time is over."""
        with self._changed:
            self._changed.wait_for(lambda: all(topic in self._samples for topic in topics), seconds)
            return dict(self._samples)


def check_topics(
    session: zenoh.Session, robots: Sequence[RobotMapping], listen_s: float, budget: Budget
) -> Iterator[Finding]:
    """Listen to every topic of a mapping, all at once.

    Args:
        session: with the router.
        robots: the mapping.
        listen_s: for how long at most.
        budget: the time that is left.
    """
    wanted = [(robot, each) for robot in robots for each in robot.subscriptions]
    first = _First()
    with ExitStack() as stack:
        for topic in {each.topic for _, each in wanted}:
            for expression in expressions(topic):
                hear = Callback(first.hearer(topic), indirect=False)
                declared: Any = session.declare_subscriber(expression, hear)
                stack.callback(declared.undeclare)
        heard = first.wait([each.topic for _, each in wanted], budget.step(listen_s))
    silent = [each for _, each in wanted if each.topic not in heard]
    published = _published(session, budget) if silent else []
    for robot, each in wanted:
        check = f"{robot.name} /{each.topic}"
        if each.topic in heard:
            yield _heard(check, each, heard[each.topic])
        else:
            yield _silent(check, each, published, listen_s)


def _published(session: zenoh.Session, budget: Budget) -> list[str]:
    """Topics that ROS 2 nodes say they publish, where the router lets us see that."""
    found = []
    for key in alive(session, _RMW_PUBLISHERS, budget):
        chunks = key.split("/")
        if "MP" in chunks:
            found += [chunk.strip("%").replace("%", "/") for chunk in chunks if chunk.startswith("%") and chunk != "%"]
    for key in alive(session, _BRIDGES_PUBLISHERS, budget):
        _, _, told = key.partition("/@ros2_lv/MP/")
        if told:
            found.append(told.split("/")[0].replace("§", "/").strip("/"))
    return sorted(set(found))


def _silent(check: str, each: Subscription, published: list[str], listen_s: float) -> Finding:
    seen = f"nothing within {listen_s:g} s"
    if each.topic in published:
        seen += ", though a node says that it publishes it"
        return Finding(check, "wrong", seen, "is the sensor on? does `ros2 topic hz` show it on the robot itself?")
    if published:
        seen += f"; published are {', '.join(f'/{topic}' for topic in published[:8])}"
        return Finding(check, "wrong", seen, "check namespace and topic in the mapping")
    advice = "is the robot on, and its bridge or rmw_zenoh joined to this router? ROS_DOMAIN_ID, namespace?"
    return Finding(check, "wrong", seen, advice)


def _heard(check: str, each: Subscription, sample: _Sample) -> Finding:
    if sample.type_name not in (None, each.type.name):
        found = f"found a {sample.type_name}"
        return Finding(check, "wrong", found, f"expected {each.type.name}: is it the right topic?")
    try:
        message = _decoded(each, sample.payload)
    except InvalidCdr as error:
        return Finding(check, "wrong", str(error), f"expected {each.type.name}: is it the right topic?")
    seen = f"{len(message.ranges)} beams" if isinstance(message, LaserScan) else "heard"
    if message.stamp.sec == 0:
        return Finding(check, "warning", f"{seen}, without a time", "poses cannot be matched with scans: stamp both")
    late = sample.at_s - message.stamp.seconds
    if -CLOCK_S <= late <= _TRAVELS_S:
        return Finding(check, "ok", f"{seen}, stamped {late:.2f} s before it came")
    seen += f", stamped {abs(late):.2f} s {'before' if late > 0.0 else 'after'} it came"
    return Finding(check, "warning", seen, "set the robot's clock by NTP or chrony")


def _decoded(each: Subscription, payload: bytes) -> LaserScan | Odometry | PoseWithCovariance:
    if each.type == LASER_SCAN:
        return decode_laser_scan(payload)
    return decode_odometry(payload) if each.type == ODOMETRY else decode_pose(payload)
