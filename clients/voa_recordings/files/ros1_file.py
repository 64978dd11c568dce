"""ROS 1 bags, read by the library rosbags; messages that looks are made from are converted to ROS 2's CDR."""

import shlex
from collections.abc import Iterator
from contextlib import ExitStack
from pathlib import Path

from rosbags.interfaces import Connection
from rosbags.rosbag1 import Reader

from voa_recordings.files.message import RecordedMessage, UnreadableRecording
from voa_recordings.files.ros_types import RosTypes


class Ros1File:
    """Reader of a ROS 1 bag.

    Attributes:
        topics: type of each topic, by its name; types are named as in ROS 2.
        damage: of the file, noticed so far, as predicates ("ends in the middle").
    """

    def __init__(self, path: Path, types: RosTypes, stack: ExitStack) -> None:
        """Prepare to read `path`; the file is closed with `stack`."""
        self.topics: dict[str, str] = {}
        self.damage: list[str] = []
        self._path = path
        self._types = types
        self._stack = stack

    def scan(self) -> int | None:
        """Read the bag's index, and return the smallest log time in nanoseconds; None: there is no message.

        Raises:
            UnreadableRecording: the bag has no index, or a damaged one; the message names the command that repairs it.
        """
        try:
            self._reader = self._stack.enter_context(Reader(self._path))
        except Exception as error:  # rosbags raises AssertionError, too, for a damaged bag
            where = shlex.quote(str(self._path))
            raise UnreadableRecording(
                f"{self._path} is a ROS 1 bag that cannot be read ({error or type(error).__name__}); `rosbag reindex "
                f"{where}` rebuilds its index, `rosbags-convert --src {where} --dst CONVERTED` converts a whole bag"
            ) from error
        self.topics = {each.topic: each.msgtype for each in self._reader.connections}
        return self._reader.start_time if self._reader.message_count else None

    def messages(self) -> Iterator[RecordedMessage]:
        """Give every message before the damage, by log time."""
        sums = self._types.ros1_sums()
        alike = {each.id: sums.get(each.msgtype) == each.digest for each in self._reader.connections}
        messages = self._reader.messages()
        while True:
            try:
                connection, log_ns, data = next(messages)
            except StopIteration:
                return
            except Exception as error:  # rosbags and its decompressors raise many kinds; messages before stay valid
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
