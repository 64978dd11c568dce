"""Retries of calls: decisions when to try again and when to give up, without I/O, for every transport."""

import math
import random
import time
import uuid
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

from voa_client._call import Call
from voa_client._errors import UnavailableError, UnreachableError, UsageError, VoaClientError

TIMEOUT_S = 120.0
ATTEMPT_S = 5.0
_LONGEST_KEY = 255


def new_key() -> str:
    """Make a new idempotency key, 32 random hexadecimal digits."""
    return uuid.uuid4().hex


@dataclass(frozen=True)
class Retries:
    """Waits between the attempts of a call that was not answered.

    The waits double from `first_s` to `most_s`, each shortened at random by up to a half, so that robots which lost the
    service at the same time do not all return at the same time. A longer wait that the service requests is respected.

    Attributes:
        first_s: first wait, seconds.
        most_s: longest wait, seconds.
        within_s: seconds after the first attempt in which further ones may begin; the call's time-out holds as well.
    """

    first_s: float = 0.1
    most_s: float = 2.0
    within_s: float = math.inf

    def wait_s(self, failures: int, chance: float) -> float:
        """Return the wait in seconds after a number of failures in a row; `chance` is uniform in [0, 1)."""
        # 64 doublings reach any longest wait; more would overflow a float.
        return min(self.most_s, self.first_s * 2.0 ** min(failures - 1, 64)) * (1.0 - chance / 2.0)


RETRIES = Retries()


@dataclass(frozen=True)
class Patience:
    """Time limits of a client's calls, with the clock and the random generators that they use.

    Attributes:
        timeout_s: longest duration of a call with all its attempts, seconds.
        attempt_s: longest duration of an attempt, seconds; heavy calls may use all of `timeout_s` for one.
        retries: waits between attempts.
        clock: returns seconds that never go back.
        chance: returns random numbers, uniform in [0, 1).
        keys: returns new idempotency keys.
    """

    timeout_s: float = TIMEOUT_S
    attempt_s: float = ATTEMPT_S
    retries: Retries = RETRIES
    clock: Callable[[], float] = time.monotonic
    chance: Callable[[], float] = random.random
    keys: Callable[[], str] = new_key

    def __post_init__(self) -> None:
        for name in ("timeout_s", "attempt_s"):
            value = getattr(self, name)
            if not 0.0 < value < math.inf:
                raise UsageError(f"{name}: expected seconds above 0, got {value}")

    def key(self, call: Call[Any], given: str | None) -> str | None:
        """Return the idempotency key of a call's attempts, None for reads; raises UsageError if `given` is invalid."""
        if not call.writes:
            return None
        if given is None:
            return self.keys()
        if not 0 < len(given) <= _LONGEST_KEY or not given.isascii() or not given.isprintable():
            raise UsageError(f"key: expected 1 to {_LONGEST_KEY} printable ASCII characters, got {given!r}")
        return given


class Attempts:
    """Attempts of one call: their durations, and the pauses between them."""

    def __init__(self, patience: Patience, *, heavy: bool) -> None:
        self._patience = patience
        self._began = patience.clock()
        self._most = patience.timeout_s if heavy else patience.attempt_s
        self._failures = 0

    @property
    def seconds(self) -> float:
        """Longest duration of the next attempt, seconds."""
        left = self._began + self._patience.timeout_s - self._patience.clock()
        return max(0.001, min(self._most, left))

    def pause(self, error: VoaClientError) -> float:
        """Return the seconds to wait before the next attempt; raises the error if there is to be none."""
        if not worth_another(error):
            raise error
        self._failures += 1
        patience = self._patience
        wait = patience.retries.wait_s(self._failures, patience.chance())
        if isinstance(error, UnavailableError) and error.retry_after_s is not None:
            wait = max(wait, error.retry_after_s)
        over = patience.clock() - self._began + wait
        if over >= patience.timeout_s or over > patience.retries.within_s:
            raise error
        return wait


def worth_another(error: VoaClientError) -> bool:
    """True if the same call may succeed later; repeating writes is safe because their attempts share a key."""
    return isinstance(error, UnreachableError | UnavailableError)
