"""Subscribers of a recorder: every sample comes into the inbox once, and so does the newest of a latched topic."""

from collections.abc import Callable, Iterator, Sequence
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass
from typing import Any

import zenoh
from zenoh.handlers import Callback

from voa_client.zenoh_session import declare_latched_subscriber
from voa_recordings.recorder.copies import Copies
from voa_recordings.recorder.inbox import Inbox, Received
from voa_ros.messages import NANOSECONDS

_RMW_CHUNKS = 4


@dataclass(frozen=True)
class Wanted:
    """Key expressions to subscribe to, in Zenoh's canonical form.

    Attributes:
        keys: of the service: scans, beliefs and refusals.
        topics: as a bridge writes them; what their publishers keep for whoever comes later is fetched.
        of_rmw: as rmw_zenoh writes them, of which only its own keys are meant: `*/rb/*/*/**` for topics below `/rb`
            matches other keys, too. What publishers keep is fetched.
    """

    keys: Sequence[str]
    topics: Sequence[str] = ()
    of_rmw: Sequence[str] = ()


@dataclass(frozen=True)
class _Expression:
    """One of the expressions: `before` are those whose samples are left to them."""

    text: str
    before: Sequence[zenoh.KeyExpr]
    of_topic: bool
    of_rmw: bool

    def accepts(self, key: zenoh.KeyExpr) -> bool:
        """Whether a sample with this key is received by this expression, and by none before it."""
        if any(expression.includes(key) for expression in self.before):
            return False
        return not self.of_rmw or is_of_rmw(str(key))


@contextmanager
def listening(session: zenoh.Session, wanted: Wanted, inbox: Inbox, now_ns: Callable[[], int]) -> Iterator[None]:
    """Put every sample on any of the expressions into the inbox, once, for the length of a `with`.

    Topics have two subscribers each. The plain one receives everything that is put from now on. An advanced one, which
    fetches what was put before, leaves out samples that overtake one another on their way (27 of 15000 of three
    publishers through one router), so that only what it alone receives is taken from it.
    """
    copies = Copies()
    with ExitStack() as stack:
        for expression in _in_order(wanted):
            plain: Any = session.declare_subscriber(
                expression.text, _callback(expression, inbox, now_ns, copies.is_new_live)
            )
            stack.callback(plain.undeclare)
            if expression.of_topic:
                receive = _callback(expression, inbox, now_ns, copies.is_new_fetched)
                stack.callback(declare_latched_subscriber(session, expression.text, receive).undeclare)
        yield


def _in_order(wanted: Wanted) -> list[_Expression]:
    """List every expression once; those of rmw_zenoh accept less, and are the last."""
    kinds = [(text, (False, False)) for text in wanted.keys]
    kinds += [(text, (True, False)) for text in wanted.topics] + [(text, (True, True)) for text in wanted.of_rmw]
    first: dict[str, tuple[bool, bool]] = {}
    for text, kind in kinds:
        first.setdefault(text, kind)
    known = [zenoh.KeyExpr(text) for text in first]
    return [_Expression(text, known[:index], *kind) for index, (text, kind) in enumerate(first.items())]


def _callback(
    expression: _Expression, inbox: Inbox, now_ns: Callable[[], int], is_new: Callable[[zenoh.Sample], bool]
) -> "Callback[zenoh.Sample]":
    def receive(sample: zenoh.Sample) -> None:
        if expression.accepts(sample.key_expr) and is_new(sample):
            inbox.put(_received(sample, now_ns()))

    return Callback(receive, indirect=False)


def _received(sample: zenoh.Sample, log_ns: int) -> Received:
    return Received(
        key=str(sample.key_expr),
        payload=sample.payload.to_bytes(),
        attachment=b"" if sample.attachment is None else sample.attachment.to_bytes(),
        encoding=str(sample.encoding),
        deleted=sample.kind == zenoh.SampleKind.DELETE,
        log_ns=log_ns,
        sent_ns=None if sample.timestamp is None else _nanoseconds(sample.timestamp),
    )


def _nanoseconds(stamp: zenoh.Timestamp) -> int:
    time = stamp.get_time_as_ntp64()
    return time.as_secs() * NANOSECONDS + time.subsec_nanos()


def is_of_rmw(key: str) -> bool:
    """Whether a key is one of rmw_zenoh's: `<domain>/<topic>/<type>/<hash>`."""
    chunks = key.split("/")
    return len(chunks) >= _RMW_CHUNKS and chunks[0].isdecimal() and "::dds_::" in chunks[-2]
