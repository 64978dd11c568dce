"""How the service and its clients join Zenoh: the settings of a session, as data.

Client mode, for everybody: sessions in peer mode behind one router do not hear each other, clients hear all. A
client's session is opened where a router answers, and from then on joins again by itself. Nobody is searched for:
no multicast, no gossip. Shared memory is off: under load its watchdog drops messages without a word.
"""

from collections.abc import Sequence
from typing import Any

_AGAIN_MS = {"period_init_ms": 200, "period_max_ms": 1000, "period_increase_factor": 2}


def session_config(
    endpoints: Sequence[str], user: str | None = None, password: str | None = None, open_ms: int = 0
) -> dict[str, Any]:
    """Entries of a Zenoh configuration, by path; each value is to be inserted as JSON.

    Args:
        endpoints: of routers, `tcp/192.168.0.2:7447`; the first that answers is taken.
        user: for the router's user/password authentication.
        password: the same.
        open_ms: how long opening waits for a router; 0: one try.
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
