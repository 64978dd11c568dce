"""Subscription to topics whose newest message is kept for late subscribers (transient local in ROS), as AMCL's pose."""

from typing import Any

import zenoh
from zenoh.ext import HistoryConfig, declare_advanced_subscriber
from zenoh.handlers import Callback


def declare_latched_subscriber(session: zenoh.Session, expression: str, receive: "Callback[zenoh.Sample]") -> Any:
    """Subscribe to a key expression, and fetch the message that its publishers keep, also of publishers to come.

    AMCL publishes when the robot has moved by 0.25 m: a plain subscriber would wait for ever for a parked robot.
    """
    history = HistoryConfig(detect_late_publishers=True, max_samples=1)
    return declare_advanced_subscriber(session, expression, receive, history=history)
