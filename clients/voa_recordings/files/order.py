"""Merging of messages by log time, from pieces that each fit into memory."""

from collections import deque
from collections.abc import Callable, Iterable, Iterator
from heapq import heappop, heappush
from typing import NamedTuple, Protocol

from voa_recordings.files.message import RecordedMessage


class Piece(NamedTuple):
    """A part of a recording that is opened when the log time of its first message is reached.

    Attributes:
        first_ns: its smallest log time, nanoseconds.
        read: gives its messages in the order of their log times.
    """

    first_ns: int
    read: Callable[[], Iterator[RecordedMessage]]


class Storage(Protocol):
    """Reader of a storage file of a recording."""

    @property
    def topics(self) -> dict[str, str]:
        """Type of each topic, by the topic's name."""

    @property
    def damage(self) -> list[str]:
        """Damage of the file that was noticed so far, as predicates ("ends in the middle")."""

    def scan(self) -> int | None:
        """Read through the file once and return its smallest log time in nanoseconds; None: it has no message.

        Raises:
            UnreadableRecording: no part of the file can be read.
        """

    def messages(self) -> Iterator[RecordedMessage]:
        """Give every readable message by log time; called after `scan`."""


def in_log_order(pieces: Iterable[Piece]) -> Iterator[RecordedMessage]:
    """Give the messages of all pieces by log time; equal times come in the order of the pieces.

    A piece is opened when the log time of its first message is reached, so that only pieces whose times overlap are
    open at once.
    """
    waiting = deque(sorted(enumerate(pieces), key=lambda numbered: numbered[1].first_ns))
    heads: list[tuple[int, int, RecordedMessage, Iterator[RecordedMessage]]] = []
    while waiting or heads:
        while waiting and (not heads or waiting[0][1].first_ns <= heads[0][0]):
            number, piece = waiting.popleft()
            _push(heads, number, piece.read())
        if heads:
            _, number, message, rest = heappop(heads)
            yield message
            _push(heads, number, rest)


def _push(
    heads: list[tuple[int, int, RecordedMessage, Iterator[RecordedMessage]]],
    number: int,
    messages: Iterator[RecordedMessage],
) -> None:
    message = next(messages, None)
    if message is not None:
        heappush(heads, (message.log_ns, number, message, messages))
