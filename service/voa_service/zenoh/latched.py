"""Topics whose newest message is kept for whoever comes later, such as AMCL's pose (transient local in ROS)."""

from typing import Any

import zenoh
from zenoh.ext import HistoryConfig, declare_advanced_subscriber
from zenoh.handlers import Callback


def declare_latched_subscriber(session: zenoh.Session, expression: str, receive: "Callback[zenoh.Sample]") -> Any:
    """Subscribe to a key expression, and fetch what its publishers keep, now and when a publisher appears later.

    AMCL publishes when the robot has moved by 0.25 m: a plain subscriber that comes to a parked robot waits for ever.
    """
    history = HistoryConfig(detect_late_publishers=True, max_samples=1)
    return declare_advanced_subscriber(session, expression, receive, history=history)
