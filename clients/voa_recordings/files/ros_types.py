"""ROS 2 message definitions: what a recording carries, so that others can read it, and what one may say differently."""

import re
import struct
from collections.abc import Callable

from rosbags.serde import SerdeError
from rosbags.typesys import Stores, get_types_from_idl, get_types_from_msg, get_typestore
from rosbags.typesys.store import Typestore

LASER_SCAN = "sensor_msgs/msg/LaserScan"
ODOMETRY = "nav_msgs/msg/Odometry"
POSE_WITH_COVARIANCE = "geometry_msgs/msg/PoseWithCovarianceStamped"
UNDERSTOOD = (LASER_SCAN, ODOMETRY, POSE_WITH_COVARIANCE)
"""Types that a look needs."""

_RIHS01 = re.compile("RIHS01_[0-9a-f]{64}")
_IDL_FILE = "=" * 80 + "\nIDL: "

Decoded = Callable[[bytes], bytes]


class RosTypes:
    """The message types of ROS 2, as its releases define them.

    Attributes:
        store: all of them.
    """

    def __init__(self) -> None:
        self.store = get_typestore(Stores.ROS2_JAZZY)

    def definition(self, type_name: str, type_hash: str | None = None) -> str | None:
        """The text of a type and of all that it is made of ("ros2msg").

        Args:
            type_name: as in "sensor_msgs/msg/LaserScan".
            type_hash: of the definition that is meant ("RIHS01_..."); None, or any other text: not known.

        Returns:
            None where no release defines the type, or not with this hash.
        """
        if type_name not in self.store.fielddefs:
            return None
        is_told = type_hash is not None and _RIHS01.fullmatch(type_hash) is not None
        if is_told and self.store.hash_rihs01(type_name) != type_hash:
            return None
        return self.store.generate_msgdef(type_name, ros_version=2)[0]

    def to_standard(self, type_name: str, own: Typestore) -> Decoded:
        """Make a function that brings a payload from the layout that a recording defines into the standard one.

        Args:
            type_name: of the payload, one of `UNDERSTOOD`.
            own: the types as the recording defines them.

        Returns:
            A function from CDR to CDR; the identity where both say the same.
        """
        standard = self.store
        try:
            if type_name not in own.fielddefs or own.hash_rihs01(type_name) == standard.hash_rihs01(type_name):
                return _unchanged
        except KeyError:  # a definition without the definitions of its parts
            return _unchanged

        def laid_out(data: bytes) -> bytes:
            try:
                return bytes(standard.serialize_cdr(own.deserialize_cdr(data, type_name), type_name))
            except (SerdeError, AttributeError, AssertionError, struct.error):
                return data  # not what its type says: whoever decodes it tells why

        return laid_out

    @staticmethod
    def is_understood(type_name: str) -> bool:
        """Whether a look needs messages of this type."""
        return type_name in UNDERSTOOD

    @staticmethod
    def ros1_sums() -> dict[str, str]:
        """The MD5 sums by which ROS 1 knows the types that a look needs; apart from a header's `seq` they are alike."""
        ros1 = get_typestore(Stores.ROS1_NOETIC)
        return {name: ros1.generate_msgdef(name, ros_version=1)[1] for name in UNDERSTOOD}

    def ros1_to_cdr(self, type_name: str, data: bytes) -> bytes:
        """Bring a ROS 1 payload into ROS 2's CDR; raises ValueError where it is not what its type says."""
        try:
            return bytes(self.store.ros1_to_cdr(data, type_name))
        except (SerdeError, AssertionError, struct.error) as error:
            raise ValueError(f"expected a {type_name} of ROS 1: {error}") from error

    def defined(self, type_name: str, encoding: str, text: str) -> Typestore:
        """The types that a recording's schema defines; none where it is not to be understood."""
        own = get_typestore(Stores.EMPTY)
        try:
            if encoding == "ros2msg":
                own.register(get_types_from_msg(text, type_name))
            elif encoding == "ros2idl":
                for part in _idl_files(text):
                    own.register(get_types_from_idl(part))
        except Exception:  # rosbags lets KeyErrors of other people's definitions through, besides errors of its own
            return get_typestore(Stores.EMPTY)
        return own


def _idl_files(text: str) -> list[str]:
    """The files of a definition: rosbag2 puts a line of 80 "=" and one that names the file above each."""
    if not text.startswith(_IDL_FILE):
        return [text]
    return [file.partition("\n")[2] for file in text.split(_IDL_FILE)[1:]]


def _unchanged(data: bytes) -> bytes:
    return data
