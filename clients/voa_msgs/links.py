"""Settings of the Zenoh sessions that the service and its clients open.

All of them use client mode: peers behind one router do not receive each other's messages, clients receive all.
Opening a session needs a router that answers; later the session reconnects by itself. Multicast and gossip scouting are
off, and so is shared memory, whose watchdog drops messages without notice under load.
"""

from collections.abc import Sequence
from typing import Any

_AGAIN_MS = {"period_init_ms": 200, "period_max_ms": 1000, "period_increase_factor": 2}


def session_config(
    endpoints: Sequence[str], user: str | None = None, password: str | None = None, open_ms: int = 0
) -> dict[str, Any]:
    """Build the entries of a Zenoh configuration, by path; each value is to be inserted as JSON.

    Args:
        endpoints: endpoints of routers, such as `tcp/192.168.0.2:7447`; the first that answers is used.
        user: user name, where the router authenticates by user and password.
        password: password of that user.
        open_ms: milliseconds for which opening the session waits for a router; 0: one try.
    """
    entries: dict[str, Any] = {
        "mode": "client",
        "connect": {"endpoints": list(endpoints), "timeout_ms": open_ms, "exit_on_failure": True, "retry": _AGAIN_MS},
        "scouting/multicast/enabled": False,
        "scouting/gossip/enabled": False,
        "transport/shared_memory/enabled": False,
    }
    if user is not None:
        entries["transport/auth/usrpwd"] = {"user": user, "password": password or ""}
    return entries
