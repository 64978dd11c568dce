"""Subscribers of a recorder: each sample, and the newest of each latched topic, is put into the inbox once."""

from collections.abc import Callable, Iterator, Sequence
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass
from typing import Any

import zenoh
from zenoh.handlers import Callback

from voa_recordings.recorder.copies import Copies
from voa_recordings.recorder.inbox import Inbox, ReceivedSample
from voa_ros.latched import declare_latched_subscriber
from voa_ros.messages import NANOSECONDS

_RMW_CHUNKS = 4


@dataclass(frozen=True)
class Wanted:
    """Key expressions to subscribe to, in Zenoh's canonical form.

    Attributes:
        keys: of the service: scans, beliefs and refusals.
        topics: of ROS topics as a bridge writes them; messages that their publishers keep (latched) are fetched.
        of_rmw: of ROS topics as rmw_zenoh writes them; latched messages are fetched. Samples on other keys are
            ignored: `*/rb/*/*/**`, for topics below `/rb`, matches more than the keys of rmw_zenoh.
    """

    keys: Sequence[str]
    topics: Sequence[str] = ()
    of_rmw: Sequence[str] = ()


@dataclass(frozen=True)
class _Expression:
    """A key expression to subscribe to, without the samples that the expressions in `before` receive."""

    text: str
    before: Sequence[zenoh.KeyExpr]
    of_topic: bool
    of_rmw: bool

    def accepts(self, key: zenoh.KeyExpr) -> bool:
        """True if a sample with this key belongs to this expression, and to none in `before`."""
        if any(expression.includes(key) for expression in self.before):
            return False
        return not self.of_rmw or is_of_rmw(str(key))


@contextmanager
def listening(session: zenoh.Session, wanted: Wanted, inbox: Inbox, now_ns: Callable[[], int]) -> Iterator[None]:
    """Put each sample on any of the expressions into the inbox once, for the length of a `with`.

    Topics have two subscribers each: a plain one, which receives every sample from now on, and an advanced one, which
    fetches earlier samples that publishers keep. The advanced one alone would not do, because it drops samples that
    overtake one another (27 of 15000, three publishers through one router).
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
    """List each expression once; those of rmw_zenoh come last, because they ignore keys of another form."""
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


def _received(sample: zenoh.Sample, log_ns: int) -> ReceivedSample:
    return ReceivedSample(
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
    """True if a key has the form of rmw_zenoh's: `<domain>/<topic>/<type>/<hash>`."""
    chunks = key.split("/")
    return len(chunks) >= _RMW_CHUNKS and chunks[0].isdecimal() and "::dds_::" in chunks[-2]
