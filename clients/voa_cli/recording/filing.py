"""Which topic of the recording a sample belongs to, and as what."""

import json
from collections.abc import Callable

from pydantic import BaseModel

from voa_cli.recording.inbox import Heard, Told
from voa_cli.recordings.ros_types import LASER_SCAN, ODOMETRY, POSE_WITH_COVARIANCE
from voa_cli.recordings.sessions import topic_of
from voa_cli.recordings.writer import RecordingWriter
from voa_msgs.keys import Attachment, Keys
from voa_msgs.problems import Problem
from voa_msgs.scenarios import Scenario
from voa_msgs.sessions import HistoryEntry, ScanRequest, Session
from voa_ros.cdr import InvalidCdr, decode_laser_scan, decode_odometry, decode_pose
from voa_ros.messages import LaserScan, Odometry, PoseWithCovariance
from voa_ros.topics import InvalidRmwAttachment, InvalidTopic, RmwAttachment, parse_key

_MODELS: dict[str, type[BaseModel]] = {
    "belief": Session,
    "history": HistoryEntry,
    "refused": Problem,
    "scan": ScanRequest,
    "scan_attachment": Attachment,
    "scenario": Scenario,
}
_CDR_HEADER = b"\0"
_SEQUENCES = 2**32

_Decoder = Callable[[bytes], LaserScan | Odometry | PoseWithCovariance]
_DECODERS: dict[str, _Decoder] = {
    LASER_SCAN: decode_laser_scan,
    ODOMETRY: decode_odometry,
    POSE_WITH_COVARIANCE: decode_pose,
}


class Filing:
    """Writes what was heard.

    Attributes:
        unknown: payloads whose type neither their key nor they themselves tell; recorded without one.
    """

    def __init__(self, writer: RecordingWriter, keys: Keys) -> None:
        self.unknown = 0
        self._writer = writer
        self._keys = keys

    def file(self, item: Heard | Told) -> str | None:
        """Write it; the session that has moved by it, if one has."""
        if isinstance(item, Told):
            self._json(item.session, item.what, item.body, (item.log_ns, item.sent_ns), self._keys.rpc("*"))
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

    def _scan(self, session: str, item: Heard) -> None:
        times = _times(item)
        if item.payload.startswith(_CDR_HEADER):
            topic = topic_of(session, "scan")
            self._writer.add_ros(topic, LASER_SCAN, item.payload, log_ns=times[0], publish_ns=times[1], key=item.key)
        else:
            self._json(session, "scan", item.payload, times, item.key)
        beside = _without_secrets(item.attachment)
        if beside is not None:
            self._json(session, "scan_attachment", beside, times, item.key)

    def _json(self, session: str, what: str, body: bytes, times: tuple[int, int], key: str) -> None:
        model = _MODELS.get(what)
        self._writer.add_json(topic_of(session, what), model, body, log_ns=times[0], publish_ns=times[1], key=key)

    def _ros(self, item: Heard) -> None:
        try:
            told = parse_key(item.key)
            topic, named = told.topic, told.type_name
        except InvalidTopic:
            topic, named = item.key, None
        stamped = _stamped(item.payload, named)
        type_name = named if stamped is None else stamped[0]
        self.unknown += type_name is None
        attached = _rmw(item.attachment)
        self._writer.add_ros(
            f"/{topic}",
            type_name,
            item.payload,
            log_ns=item.log_ns,
            publish_ns=_published(item, attached, stamped),
            key=item.key,
            sequence=0 if attached is None else attached.sequence % _SEQUENCES,
        )


def _stamped(payload: bytes, named: str | None) -> tuple[str, int] | None:
    """The type of a payload and the time in its header; None where it is none of the three that are understood."""
    for name, decode in _DECODERS.items():
        if named not in (None, name):
            continue
        try:
            stamp = decode(payload).stamp
        except InvalidCdr:
            continue
        return name, stamp.sec * 1_000_000_000 + stamp.nanosec
    return None


def _published(item: Heard, attached: RmwAttachment | None, stamped: tuple[str, int] | None) -> int:
    """When it was sent, by whoever knows best."""
    times = [item.sent_ns, None if attached is None else attached.source_ns, None if stamped is None else stamped[1]]
    return next((time for time in times if time is not None and time > 0), item.log_ns)


def _times(item: Heard) -> tuple[int, int]:
    return item.log_ns, item.log_ns if item.sent_ns is None else item.sent_ns


def _rmw(attachment: bytes) -> RmwAttachment | None:
    try:
        return RmwAttachment.decode(attachment)
    except InvalidRmwAttachment:
        return None


def _without_secrets(attachment: bytes) -> bytes | None:
    """An attachment of the service's without its API key; None: it is none, or says nothing else."""
    try:
        told = json.loads(attachment)
    except ValueError:
        return None
    kept = {name: value for name, value in told.items() if name != "key"} if isinstance(told, dict) else {}
    return json.dumps(kept).encode() if kept else None
