"""Samples between Zenoh's threads and the one that writes."""

import queue
from collections.abc import Callable, Iterator, Sequence
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass
from typing import Any

import zenoh
from zenoh.handlers import Callback

MOST_WAITING = 16_384
NANOSECONDS = 1_000_000_000
_RMW_CHUNKS = 4


@dataclass(frozen=True)
class Heard:
    """A sample as it came.

    Attributes:
        attachment: b"" for none.
        encoding: as Zenoh writes it.
        deleted: it is the end of its key, and has no payload.
        log_ns: when it came, nanoseconds since 1970.
        sent_ns: when a router first saw it; None: it does not say.
    """

    key: str
    payload: bytes
    attachment: bytes
    encoding: str
    deleted: bool
    log_ns: int
    sent_ns: int | None


@dataclass(frozen=True)
class Told:
    """A message that the service was asked for: JSON for a topic of the recording."""

    session: str
    what: str
    body: bytes
    log_ns: int
    sent_ns: int


class Inbox:
    """A bounded queue. Putting never waits, since a callback that waits stalls the whole Zenoh session.

    Attributes:
        dropped: items that found it full.
    """

    def __init__(self, most: int = MOST_WAITING) -> None:
        self._held: queue.Queue[Heard | Told] = queue.Queue(most)
        self.dropped = 0

    def put(self, item: Heard | Told) -> None:
        """Keep it, or count it as dropped."""
        try:
            self._held.put_nowait(item)
        except queue.Full:
            self.dropped += 1

    def get(self, seconds: float) -> Heard | Told | None:
        """The oldest; None: nothing came within `seconds`."""
        try:
            return self._held.get(timeout=seconds) if seconds > 0.0 else self._held.get_nowait()
        except queue.Empty:
            return None


@dataclass(frozen=True)
class Wanted:
    """What to listen to.

    Attributes:
        expressions: key expressions in Zenoh's canonical form.
        of_rmw: more of them, of which only rmw_zenoh's keys are meant: `*/rb/*/*/**` for topics below `/rb` matches
            other keys, too.
    """

    expressions: Sequence[str]
    of_rmw: Sequence[str] = ()


@contextmanager
def listening(session: zenoh.Session, wanted: Wanted, inbox: Inbox, now_ns: Callable[[], int]) -> Iterator[None]:
    """Put every sample on any of the expressions into the inbox, once, for the length of a `with`."""
    of_rmw = [expression for expression in dict.fromkeys(wanted.of_rmw) if expression not in wanted.expressions]
    plain = list(dict.fromkeys(wanted.expressions))
    known = [zenoh.KeyExpr(expression) for expression in (*plain, *of_rmw)]  # those of rmw_zenoh accept less: last
    with ExitStack() as stack:
        for index, expression in enumerate(known):
            hear = _hearer(known[:index], inbox, now_ns, of_rmw=index >= len(plain))
            declared: Any = session.declare_subscriber(expression, Callback(hear, indirect=False))
            stack.callback(declared.undeclare)
        yield


def _hearer(
    before: Sequence[zenoh.KeyExpr], inbox: Inbox, now_ns: Callable[[], int], *, of_rmw: bool
) -> Callable[[zenoh.Sample], None]:
    """A callback that leaves to earlier expressions what they receive too."""

    def hear(sample: zenoh.Sample) -> None:
        if any(expression.includes(sample.key_expr) for expression in before):
            return
        if of_rmw and not is_of_rmw(str(sample.key_expr)):
            return
        inbox.put(
            Heard(
                key=str(sample.key_expr),
                payload=sample.payload.to_bytes(),
                attachment=b"" if sample.attachment is None else sample.attachment.to_bytes(),
                encoding=str(sample.encoding),
                deleted=sample.kind == zenoh.SampleKind.DELETE,
                log_ns=now_ns(),
                sent_ns=None if sample.timestamp is None else _nanoseconds(sample.timestamp),
            )
        )

    return hear


def _nanoseconds(stamp: zenoh.Timestamp) -> int:
    time = stamp.get_time_as_ntp64()
    return time.as_secs() * NANOSECONDS + time.subsec_nanos()


def is_of_rmw(key: str) -> bool:
    """Whether a key is one of rmw_zenoh's: `<domain>/<topic>/<type>/<hash>`."""
    chunks = key.split("/")
    return len(chunks) >= _RMW_CHUNKS and chunks[0].isdecimal() and "::dds_::" in chunks[-2]
