"""Loading of compiled kernels before the service is ready, in bounded time."""

import threading
from collections.abc import Callable

import structlog

from voa_core.loading import load_kernels

_SECONDS = 5.0
"""Time that loading may take: kernels that are not on the disk are compiled, which takes longer, beside the service."""


def load_before_ready(load: Callable[[], None] = load_kernels, seconds: float = _SECONDS) -> None:
    """Load the kernels of a scan update in a thread, and wait for it at most so many seconds.

    Args:
        load: loads them; an error is logged, since the first scan would meet it again.
        seconds: time after which the service goes on without waiting.
    """

    def loading() -> None:
        try:
            load()
        except Exception:  # whatever it is: the service answers what needs no kernel
            structlog.get_logger("voa").exception("the kernels cannot be loaded")

    thread = threading.Thread(target=loading, name="voa-kernels", daemon=True)
    thread.start()
    thread.join(seconds)
