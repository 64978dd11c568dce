"""ROS 1 bags, read by rosbags: messages that a look needs become CDR, others stay as they are."""

import shlex
from collections.abc import Iterator
from contextlib import ExitStack
from pathlib import Path

from rosbags.interfaces import Connection
from rosbags.rosbag1 import Reader

from voa_recordings.files.message import RecordedMessage, UnreadableRecording
from voa_recordings.files.ros_types import RosTypes


class Ros1File:
    """Reads one bag.

    Attributes:
        topics: name to type, of all topics; types are named as ROS 2 names them.
        damage: predicates of the file, so far as it has been read.
    """

    def __init__(self, path: Path, types: RosTypes, stack: ExitStack) -> None:
        """Prepare to read `path`; it is open as long as `stack`."""
        self.topics: dict[str, str] = {}
        self.damage: list[str] = []
        self._path = path
        self._types = types
        self._stack = stack

    def scan(self) -> int | None:
        """Read the bag's index; the smallest log time, None: no message.

        Raises:
            UnreadableRecording: the bag has no index, or a damaged one; the message names the command that repairs it.
        """
        try:
            self._reader = self._stack.enter_context(Reader(self._path))
        except Exception as error:  # rosbags asserts, too, what a damaged bag does not keep
            where = shlex.quote(str(self._path))
            raise UnreadableRecording(
                f"{self._path} is a ROS 1 bag that cannot be read ({error or type(error).__name__}); `rosbag reindex "
                f"{where}` makes its index anew, `rosbags-convert --src {where} --dst CONVERTED` converts a whole bag"
            ) from error
        self.topics = {each.topic: each.msgtype for each in self._reader.connections}
        return self._reader.start_time if self._reader.message_count else None

    def messages(self) -> Iterator[RecordedMessage]:
        """Give every message before a damage, by log time."""
        sums = self._types.ros1_sums()
        alike = {each.id: sums.get(each.msgtype) == each.digest for each in self._reader.connections}
        found = self._reader.messages()
        while True:
            try:
                connection, log_ns, data = next(found)
            except StopIteration:
                return
            except Exception as error:  # of whatever reads or decompresses the bag: what was read remains
                self.damage.append(f"is damaged ({error or type(error).__name__})")
                return
            yield self._message(connection, log_ns, data, alike=alike[connection.id])

    def _message(self, connection: Connection, log_ns: int, data: bytes, *, alike: bool) -> RecordedMessage:
        name = connection.msgtype
        try:
            cdr = self._types.ros1_to_cdr(name, data) if alike else None
        except ValueError:
            cdr = None
        if cdr is None:
            return RecordedMessage(connection.topic, name, "ros1", log_ns, bytes(data))
        return RecordedMessage(connection.topic, name, "cdr", log_ns, cdr)
