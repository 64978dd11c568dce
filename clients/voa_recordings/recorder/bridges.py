"""Types of topics, as zenoh-bridge-ros2dds announces them; the keys on which it publishes do not contain them.

For each topic that it routes, a bridge holds a liveliness token whose key contains the topic's key and type, with `§`
for `/`: `@/<zenoh id>/@ros2_lv/MP/<key>/<type>/<qos>`, or MS where it writes to DDS; older bridges leave out `@/` and
put the id after `@ros2_lv`.
"""

from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

import zenoh
from zenoh.handlers import Callback

from voa_ros.topics import type_name

TOKENS = ("@/*/@ros2_lv/M$*/*/*/*", "@ros2_lv/*/M$*/*/*/*")
_SLASH = "§"
_LAST = 3
"""Key, type and quality of service are the last chunks of a token."""


class BridgeTypes:
    """Types that bridges have announced so far; Zenoh's threads add to it."""

    def __init__(self) -> None:
        self._types: dict[str, str] = {}

    def note(self, token: str) -> None:
        """Keep the type that a token announces; any other key is ignored."""
        chunks = token.split("/")
        if len(chunks) <= _LAST:
            return
        key, announced, _ = chunks[-_LAST:]
        name = type_name(announced.replace(_SLASH, "/"))
        if name is not None:
            self._types[key.replace(_SLASH, "/")] = name

    def type_of(self, key: str) -> str | None:
        """Return the type that was announced for a key; None: none was."""
        return self._types.get(key)


@contextmanager
def announced(session: zenoh.Session) -> Iterator[BridgeTypes]:
    """Collect the announcements of all bridges, earlier ones included, for the length of a `with`."""
    types = BridgeTypes()

    def note(sample: zenoh.Sample) -> None:
        if sample.kind == zenoh.SampleKind.PUT:  # the types of a bridge that leaves stay known
            types.note(str(sample.key_expr))

    declared: list[Any] = []
    try:
        for tokens in TOKENS:
            liveliness = session.liveliness()
            declared.append(liveliness.declare_subscriber(tokens, Callback(note, indirect=False), history=True))
        yield types
    finally:
        for subscriber in declared:
            subscriber.undeclare()
