"""Filing of received samples: each goes to a topic of the recording, as a ROS message or as JSON."""

import json
from collections import Counter
from collections.abc import Callable

from voa_msgs.keys import Keys
from voa_recordings.files.ros_types import LASER_SCAN, ODOMETRY, POSE_WITH_COVARIANCE
from voa_recordings.files.sessions import topic_of
from voa_recordings.files.writer import RecordingWriter
from voa_recordings.recorder.inbox import FetchedDocument, Item, ReceivedSample, VersionOfSession
from voa_ros.cdr import InvalidCdr, decode_laser_scan, decode_odometry, decode_pose
from voa_ros.messages import NANOSECONDS, LaserScan, Odometry, PoseWithCovariance
from voa_ros.topics import InvalidRmwAttachment, InvalidTopic, RmwAttachment, parse_key

_CDR_HEADER = b"\0"
_SEQUENCES = 2**32


_Decoder = Callable[[bytes], LaserScan | Odometry | PoseWithCovariance]
_DECODERS: dict[str, _Decoder] = {
    # A scan is recorded however many beams the service would accept.
    LASER_SCAN: lambda payload: decode_laser_scan(payload, len(payload)),
    ODOMETRY: decode_odometry,
    POSE_WITH_COVARIANCE: decode_pose,
}


class Filing:
    """Writer of received samples to the topics of a recording.

    Attributes:
        unknown: per topic, the number of payloads recorded without a type, because neither their key, nor a bridge, nor
            their content shows it.
        beams: per topic, the largest number of beams of its LaserScans.
    """

    def __init__(
        self, writer: RecordingWriter, keys: Keys, announced_type: Callable[[str], str | None] = lambda _: None
    ) -> None:
        """File samples into `writer`; `announced_type` returns the type that a bridge announces for a key, or None."""
        self.unknown: Counter[str] = Counter()
        self.beams: dict[str, int] = {}
        self._writer = writer
        self._keys = keys
        self._announced_type = announced_type
        self._recognised: dict[str, str] = {}  # by key, for later payloads of the key that cannot be decoded

    def file(self, item: Item) -> str | None:
        """Write an item of the inbox; return the id of the session that a sample brings a new version of, or None."""
        if isinstance(item, FetchedDocument):
            self._json(item.session, item.what, item.body, (item.log_ns, item.sent_ns), self._keys.rpc("*"))
            return None
        if isinstance(item, VersionOfSession):
            topic = topic_of(item.session, item.what)
            self._writer.add_ros(
                topic, item.type_name, item.data, log_ns=item.at_ns, publish_ns=item.at_ns, key=self._keys.rpc("*")
            )
            return None
        below = item.key.removeprefix(f"{self._keys.root}/").split("/")
        if not item.key.startswith(f"{self._keys.root}/"):
            self._ros(item)
            return None
        match below:
            case ["belief", session]:
                what, body = ("deleted", b"{}") if item.deleted else ("belief", item.payload)
                self._json(session, what, body, _times(item), item.key)
                return None if item.deleted else session
            case ["refused", session, _] if not item.deleted:
                self._json(session, "refused", item.payload, _times(item), item.key)
            case ["scan", session, _] if not item.deleted:
                self._scan(session, item)
        return None

    def _scan(self, session: str, item: ReceivedSample) -> None:
        times = _times(item)
        if item.payload.startswith(_CDR_HEADER):
            topic = topic_of(session, "laser_scan")
            self._writer.add_ros(topic, LASER_SCAN, item.payload, log_ns=times[0], publish_ns=times[1], key=item.key)
        else:
            self._json(session, "scan", item.payload, times, item.key)
        beside = _without_secrets(item.attachment)
        if beside is not None:
            self._json(session, "scan_attachment", beside, times, item.key)

    def _json(self, session: str, what: str, body: bytes, times: tuple[int, int], key: str) -> None:
        self._writer.add_json(topic_of(session, what), body, log_ns=times[0], publish_ns=times[1], key=key)

    def _ros(self, item: ReceivedSample) -> None:
        topic, named = _of_key(item.key)
        named = named or self._announced_type(item.key)
        message = _decoded(item.payload, named)
        if message is not None:
            self._recognised[item.key] = message[0]
            if isinstance(message[1], LaserScan):
                self.beams[topic] = max(self.beams.get(topic, 0), len(message[1].ranges))
        type_name = named or self._recognised.get(item.key)
        if type_name is None:
            self.unknown[topic] += 1
        attached = _rmw(item.attachment)
        self._writer.add_ros(
            topic,
            type_name,
            item.payload,
            log_ns=item.log_ns,
            publish_ns=_published(item, attached, None if message is None else message[1]),
            key=item.key,
            sequence=0 if attached is None else attached.sequence % _SEQUENCES,
            type_hash=item.key.rpartition("/")[2],
        )


def _of_key(key: str) -> tuple[str, str | None]:
    """Return the topic of a key, and the type if the key is one of rmw_zenoh's, which contain it."""
    try:
        parsed = parse_key(key)
    except InvalidTopic:
        return f"/{key}", None
    return f"/{parsed.topic}", parsed.type_name


def _decoded(payload: bytes, named: str | None) -> tuple[str, LaserScan | Odometry | PoseWithCovariance] | None:
    """Decode a payload, and return its type and message; None: it is of none of the three types that are understood."""
    for name, decode in _DECODERS.items():
        if named not in (None, name):
            continue
        try:
            return name, decode(payload)
        except InvalidCdr:
            continue
    return None


def _published(
    item: ReceivedSample, attached: RmwAttachment | None, message: LaserScan | Odometry | PoseWithCovariance | None
) -> int:
    """Return the time of sending: by the router, the publisher, or the message's own stamp, in this order."""
    stamped = None if message is None else message.stamp.sec * NANOSECONDS + message.stamp.nanosec
    times = [item.sent_ns, None if attached is None else attached.source_ns, stamped]
    return next((time for time in times if time is not None and time > 0), item.log_ns)


def _times(item: ReceivedSample) -> tuple[int, int]:
    return item.log_ns, item.log_ns if item.sent_ns is None else item.sent_ns


def _rmw(attachment: bytes) -> RmwAttachment | None:
    try:
        return RmwAttachment.decode(attachment)
    except InvalidRmwAttachment:
        return None


def _without_secrets(attachment: bytes) -> bytes | None:
    """Remove the API key from an attachment to the service; None: nothing else is in it, or it is not JSON."""
    try:
        fields = json.loads(attachment)
    except (ValueError, RecursionError):  # any program may have sent it
        return None
    kept = {name: value for name, value in fields.items() if name != "key"} if isinstance(fields, dict) else {}
    return json.dumps(kept).encode() if kept else None
