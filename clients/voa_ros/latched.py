"""Subscription to latched topics: their publishers keep the newest message for late subscribers.

ROS calls this durability transient local; AMCL's pose is such a topic. This is the only module here that imports Zenoh.
"""

from typing import Any

import zenoh
from zenoh.ext import HistoryConfig, declare_advanced_subscriber
from zenoh.handlers import Callback


def declare_latched_subscriber(session: zenoh.Session, expression: str, receive: "Callback[zenoh.Sample]") -> Any:
    """Subscribe to a key expression, and fetch the newest message that each of its publishers keeps.

    Messages of publishers that start after the subscriber are fetched too. AMCL publishes only after the robot has
    moved by 0.25 m: a plain subscriber would wait forever for the pose of a parked robot.

    Args:
        session: open session with a router.
        expression: key expression of the topic, without a namespace.
        receive: called with each sample, on a thread of Zenoh.

    Returns:
        The subscriber; its `undeclare()` ends the subscription.
    """
    history = HistoryConfig(detect_late_publishers=True, max_samples=1)
    return declare_advanced_subscriber(session, expression, receive, history=history)
