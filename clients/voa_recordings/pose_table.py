"""Tables that state at which pose the object lay while a robot recorded its scans.

A CSV file with a header line and one row per time interval, or one row per look:

| columns            | a row says                                                                            |
|--------------------|---------------------------------------------------------------------------------------|
| `pose, from, to`   | the object lay at `pose` between two times                                            |
| `pose, from`       | the object lay at `pose` from that time until the next row's, or until the end        |
| `pose, look`       | it lay there in that look of the recording, counted from 1 as `voa replay` lists them |

Times are seconds since the first message of the recording ("12.5"), seconds since 1970, or ISO 8601 with a time zone
("2026-11-29T10:00:00Z"), by the clock of the recorder. A column `sensor` may name the sensor configuration at which
the lidar stood; without it, the robot's mapping says where it was. An empty `pose` is a time in which nobody vouches
for the object: its scans are not used.
"""

import csv
import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from datetime import datetime
from itertools import pairwise
from pathlib import Path

from voa_client import VoaClientError

_EPOCH_S = 1e8
"""Smallest number of seconds that is taken for a time since 1970: three years, longer than any recording."""


class InvalidPoseTable(VoaClientError):
    """A table of poses cannot be used; the message names the line and says what was expected."""


@dataclass(frozen=True)
class PoseRow:
    """Statement that the object lay at a pose: during a time, or in one look.

    Attributes:
        line: number of its line in the file.
        pose: name of the pose; "": not known.
        sensor: name of the sensor configuration at which the lidar stood; None: the robot's mapping says it.
        from_ns, to_ns: first and last time, nanoseconds since 1970 by the recorder's clock; None for a look.
        look: number of the look in the recording, from 1; None for a time.
    """

    line: int
    pose: str
    sensor: str | None
    from_ns: int | None
    to_ns: int | None
    look: int | None


def read_pose_table(path: Path, begin_ns: int, end_ns: int) -> list[PoseRow]:
    """Read a table of poses.

    Args:
        path: the CSV file.
        begin_ns, end_ns: times of the first and last message of the recording, nanoseconds since 1970.

    Returns:
        The rows in the order of their times or looks.

    Raises:
        InvalidPoseTable: the file cannot be read, or a row is wrong; the message names its line.
    """
    try:
        with path.open(encoding="utf-8-sig", newline="") as lines:
            reader = csv.DictReader(lines, skipinitialspace=True)
            columns = [name.strip() for name in reader.fieldnames or ()]
            reader.fieldnames = columns
            cells = [
                (reader.line_num, {key: (value or "").strip() for key, value in row.items() if key}) for row in reader
            ]
    except (OSError, UnicodeDecodeError, csv.Error) as error:
        raise InvalidPoseTable(f"{path}: {error}") from error
    by_look = "look" in columns
    if "pose" not in columns or by_look == ("from" in columns):
        raise InvalidPoseTable(
            f"{path}: expected a header line with the columns pose, and either look, or from and to; got "
            f"{', '.join(columns) or 'nothing'}"
        )
    if not cells:
        raise InvalidPoseTable(f"{path}: expected a row for each pose, and there is none")
    read = _looks if by_look else _times
    rows = read(path, cells, begin_ns, end_ns)
    _check_order(path, rows)
    return rows


def _looks(path: Path, cells: Sequence[tuple[int, Mapping[str, str]]], _begin_ns: int, _end_ns: int) -> list[PoseRow]:
    rows = []
    for line, row in cells:
        text = row.get("look", "")
        if not text.isdecimal() or int(text) < 1:
            raise InvalidPoseTable(f"{path}, line {line}: look: expected a number from 1, got {text!r}")
        rows.append(PoseRow(line, row.get("pose", ""), row.get("sensor") or None, None, None, int(text)))
    return sorted(rows, key=lambda row: row.look or 0)


def _times(path: Path, cells: Sequence[tuple[int, Mapping[str, str]]], begin_ns: int, end_ns: int) -> list[PoseRow]:
    starts = [_time_ns(path, line, "from", row.get("from", ""), begin_ns) for line, row in cells]
    rows = []
    for index, (line, row) in enumerate(cells):
        next_ns = starts[index + 1] - 1 if index + 1 < len(starts) else end_ns
        to_ns = _time_ns(path, line, "to", row["to"], begin_ns) if row.get("to") else next_ns
        if to_ns < starts[index]:
            raise InvalidPoseTable(
                f"{path}, line {line}: expected `to` after `from`, and the rows in the order of their times"
            )
        rows.append(PoseRow(line, row.get("pose", ""), row.get("sensor") or None, starts[index], to_ns, None))
    return sorted(rows, key=lambda row: row.from_ns or 0)


def _time_ns(path: Path, line: int, column: str, text: str, begin_ns: int) -> int:
    """Read a time; returns nanoseconds since 1970."""
    try:
        seconds = float(text)
    except ValueError:
        seconds = math.nan
    if math.isfinite(seconds):
        return round(seconds * 1e9) + (0 if seconds >= _EPOCH_S else begin_ns)
    try:
        when = datetime.fromisoformat(text)
    except ValueError:
        when = None
    if when is None or when.tzinfo is None:
        raise InvalidPoseTable(
            f"{path}, line {line}: {column}: expected seconds since the recording began, seconds since 1970, or a time "
            f'with its zone such as "2026-11-29T10:00:00Z", got {text!r}'
        )
    return round(when.timestamp() * 1e9)


def _check_order(path: Path, rows: Sequence[PoseRow]) -> None:
    """Raise InvalidPoseTable if two rows state a pose for one look, or for one time."""
    for before, row in pairwise(rows):
        same_look = row.look is not None and row.look == before.look
        overlap = row.from_ns is not None and before.to_ns is not None and row.from_ns <= before.to_ns
        if same_look or overlap:
            what = f"look {row.look}" if same_look else "one time"
            raise InvalidPoseTable(f"{path}, lines {before.line} and {row.line}: both state a pose for {what}")
