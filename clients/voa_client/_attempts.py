"""When to try again, and for how long: decided here, without I/O, for every transport."""

import math
import random
import time
import uuid
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

from voa_client._calls import Call
from voa_client._errors import UnavailableError, UnreachableError, UsageError, VoaClientError

TIMEOUT_S = 120.0
ATTEMPT_S = 5.0
_LONGEST_KEY = 255


def new_key() -> str:
    """An idempotency key that nobody has used."""
    return uuid.uuid4().hex


@dataclass(frozen=True)
class Retries:
    """How a call that was not answered is tried again.

    The waits double from `first_s` to `most_s`, each cut at random by up to a half, so that robots which lost the
    service together do not come back together. A service that says when to come back is obeyed.

    Attributes:
        first_s: the first wait, seconds.
        most_s: the longest.
        within_s: no new attempt begins later than this after the first; the call's own time-out holds besides.
    """

    first_s: float = 0.1
    most_s: float = 2.0
    within_s: float = math.inf

    def wait_s(self, failures: int, chance: float) -> float:
        """The wait after so many failures in a row; `chance` is uniform in [0, 1)."""
        # Beyond 64 doublings every wait is the longest, and a float would soon end.
        return min(self.most_s, self.first_s * 2.0 ** min(failures - 1, 64)) * (1.0 - chance / 2.0)


RETRIES = Retries()


@dataclass(frozen=True)
class Patience:
    """How long a client waits for what, by which clock.

    Attributes:
        timeout_s: bounds a whole call with all its attempts.
        attempt_s: bounds one attempt of a call that is not heavy.
        retries: what lies between attempts.
        clock: seconds, never going back.
        chance: uniform in [0, 1).
        keys: an idempotency key that nobody has used.
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
        """The idempotency key that all attempts of a call share; raises UsageError if `given` cannot be sent."""
        if not call.writes:
            return None
        if given is None:
            return self.keys()
        if not 0 < len(given) <= _LONGEST_KEY or not given.isascii() or not given.isprintable():
            raise UsageError(f"key: expected 1 to {_LONGEST_KEY} printable ASCII characters, got {given!r}")
        return given


class Attempts:
    """The attempts of one call."""

    def __init__(self, patience: Patience, *, heavy: bool) -> None:
        self._patience = patience
        self._began = patience.clock()
        self._most = patience.timeout_s if heavy else patience.attempt_s
        self._failures = 0

    @property
    def seconds(self) -> float:
        """How long the next attempt may take."""
        left = self._began + self._patience.timeout_s - self._patience.clock()
        return max(0.001, min(self._most, left))

    def pause(self, error: VoaClientError) -> float:
        """Seconds to wait before the next attempt; raises the error if there is none."""
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
    """Whether the same call may succeed later; writes are safe to repeat because their attempts share a key."""
    return isinstance(error, UnreachableError | UnavailableError)
