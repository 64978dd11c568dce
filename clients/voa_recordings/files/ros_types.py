"""ROS 2 message definitions: those written to recordings, and conversion from those that a recording defines itself."""

import re
import struct
from collections.abc import Callable

from rosbags.serde import SerdeError
from rosbags.typesys import Stores, get_types_from_idl, get_types_from_msg, get_typestore
from rosbags.typesys.store import Typestore

from voa_recordings.files.foxglove_types import foxglove_types

LASER_SCAN = "sensor_msgs/msg/LaserScan"
ODOMETRY = "nav_msgs/msg/Odometry"
POSE_WITH_COVARIANCE = "geometry_msgs/msg/PoseWithCovarianceStamped"
UNDERSTOOD = (LASER_SCAN, ODOMETRY, POSE_WITH_COVARIANCE)
"""Types of messages that looks are made from."""

_RIHS01 = re.compile("RIHS01_[0-9a-f]{64}")
_IDL_FILE = "=" * 80 + "\nIDL: "

Decoded = Callable[[bytes], bytes]


class RosTypes:
    """Message types of ROS 2, as its release Jazzy defines them, and of Foxglove's scenes.

    Attributes:
        store: definitions of all types, by rosbags.
    """

    def __init__(self) -> None:
        self.store = get_typestore(Stores.ROS2_JAZZY)
        self.store.register(foxglove_types())

    def definition(self, type_name: str, type_hash: str | None = None) -> str | None:
        """Return the definition of a type and of the types that it contains, in the format "ros2msg".

        Args:
            type_name: as in "sensor_msgs/msg/LaserScan".
            type_hash: hash of the sender's definition ("RIHS01_..."); None, or any other text: not known.

        Returns:
            None if no release defines the type, or none with this hash.
        """
        if type_name not in self.store.fielddefs:
            return None
        is_known = type_hash is not None and _RIHS01.fullmatch(type_hash) is not None
        if is_known and self.store.hash_rihs01(type_name) != type_hash:
            return None
        return self.store.generate_msgdef(type_name, ros_version=2)[0]

    def to_standard(self, type_name: str, own: Typestore) -> Decoded:
        """Make a function that converts a payload from the layout that a recording defines to the standard one.

        Args:
            type_name: of the payload, one of `UNDERSTOOD`.
            own: the types as the recording defines them.

        Returns:
            A function from CDR to CDR; the identity if both layouts are equal.
        """
        standard = self.store
        try:
            if type_name not in own.fielddefs or own.hash_rihs01(type_name) == standard.hash_rihs01(type_name):
                return _unchanged
        except KeyError:  # a definition without those of the types that it contains
            return _unchanged

        def laid_out(data: bytes) -> bytes:
            try:
                return bytes(standard.serialize_cdr(own.deserialize_cdr(data, type_name), type_name))
            except (SerdeError, AttributeError, AssertionError, struct.error):
                return data  # not of its type: the decoder reports that

        return laid_out

    @staticmethod
    def is_understood(type_name: str) -> bool:
        """True if looks are made from messages of this type."""
        return type_name in UNDERSTOOD

    @staticmethod
    def ros1_sums() -> dict[str, str]:
        """Return the MD5 sums of ROS 1's definitions of the understood types, which differ only in a header's `seq`."""
        ros1 = get_typestore(Stores.ROS1_NOETIC)
        return {name: ros1.generate_msgdef(name, ros_version=1)[1] for name in UNDERSTOOD}

    def ros1_to_cdr(self, type_name: str, data: bytes) -> bytes:
        """Convert a ROS 1 payload to ROS 2's CDR; raises ValueError if it is not of its type."""
        try:
            return bytes(self.store.ros1_to_cdr(data, type_name))
        except (SerdeError, AssertionError, struct.error) as error:
            raise ValueError(f"expected a {type_name} of ROS 1: {error}") from error

    def defined(self, type_name: str, encoding: str, text: str) -> Typestore:
        """Parse the types that a recording's schema defines; an empty store if it cannot be parsed."""
        own = get_typestore(Stores.EMPTY)
        try:
            if encoding == "ros2msg":
                own.register(get_types_from_msg(text, type_name))
            elif encoding == "ros2idl":
                for part in _idl_files(text):
                    own.register(get_types_from_idl(part))
        except Exception:  # rosbags raises KeyError, too, for definitions that it cannot parse
            return get_typestore(Stores.EMPTY)
        return own


def _idl_files(text: str) -> list[str]:
    """Split a definition into its files: rosbag2 writes a line of 80 "=" and one with the file's name above each."""
    if not text.startswith(_IDL_FILE):
        return [text]
    return [file.partition("\n")[2] for file in text.split(_IDL_FILE)[1:]]


def _unchanged(data: bytes) -> bytes:
    return data
