"""ROS 2 message definitions: what a recording carries, so that others can read it, and what one may say differently."""

from collections.abc import Callable

from rosbags.typesys import Stores, TypesysError, get_types_from_idl, get_types_from_msg, get_typestore
from rosbags.typesys.store import Typestore

LASER_SCAN = "sensor_msgs/msg/LaserScan"
ODOMETRY = "nav_msgs/msg/Odometry"
POSE_WITH_COVARIANCE = "geometry_msgs/msg/PoseWithCovarianceStamped"
UNDERSTOOD = (LASER_SCAN, ODOMETRY, POSE_WITH_COVARIANCE)
"""Types that a look needs."""

Decoded = Callable[[bytes], bytes]


class RosTypes:
    """The message types of ROS 2, as its releases define them.

    Attributes:
        store: all of them.
    """

    def __init__(self) -> None:
        self.store = get_typestore(Stores.ROS2_JAZZY)

    def definition(self, type_name: str) -> str | None:
        """The text of a type and of all that it is made of ("ros2msg"); None: no release defines it."""
        if type_name not in self.store.fielddefs:
            return None
        return self.store.generate_msgdef(type_name, ros_version=2)[0]

    def to_standard(self, type_name: str, own: Typestore) -> Decoded:
        """What brings a payload from the layout that a recording defines into the standard one.

        Args:
            type_name: of the payload, one of `UNDERSTOOD`.
            own: the types as the recording defines them.

        Returns:
            A function from CDR to CDR; the identity where both say the same.
        """
        standard = self.store
        if type_name not in own.fielddefs or own.hash_rihs01(type_name) == standard.hash_rihs01(type_name):
            return _unchanged
        return lambda data: bytes(standard.serialize_cdr(own.deserialize_cdr(data, type_name), type_name))

    def defined(self, type_name: str, encoding: str, text: str) -> Typestore:
        """The types that a recording's schema defines; none where it is not to be understood."""
        own = get_typestore(Stores.EMPTY)
        try:
            if encoding == "ros2msg":
                own.register(get_types_from_msg(text, type_name))
            elif encoding == "ros2idl":
                own.register(get_types_from_idl(text))
        except TypesysError:
            return get_typestore(Stores.EMPTY)
        return own


def _unchanged(data: bytes) -> bytes:
    return data
