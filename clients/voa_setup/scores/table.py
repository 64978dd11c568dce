"""`scores.csv`: successes and attempts of each grasp at each pose, one row per pair, which a lab fills by hand.

It has a row per pair and not a table of "k/n", because spreadsheets turn 3/15 into a date. Columns: `grasp`, `pose`,
`successes`, `attempts`, in any order; others are ignored, so that the CSV of `voa evaluate grasp-score` is read too.
"""

import csv
from collections.abc import Sequence
from pathlib import Path

from voa_fleet.errors import FleetError
from voa_msgs.scenarios import GivenScores, MeasuredScores

COLUMNS = ("grasp", "pose", "successes", "attempts")
_MOST = 1_000_000
_LISTED = 3


class InvalidScores(FleetError):
    """A table of scores cannot be read, or does not fit the scenario; the message says which row and what to do."""


def write_scores(file: Path, grasps: Sequence[str], poses: Sequence[str], scores: MeasuredScores) -> None:
    """Write measured scores, grasp by grasp.

    Args:
        file: to write.
        grasps, poses: names, in the order of the scores.
        scores: successes (grasps, poses) of a number of attempts each.
    """
    with file.open("w", encoding="utf-8", newline="") as lines:
        writer = csv.writer(lines, lineterminator="\n")
        writer.writerow(COLUMNS)
        for grasp, row in zip(grasps, scores.successes, strict=True):
            writer.writerows([grasp, pose, count, scores.attempts] for pose, count in zip(poses, row, strict=True))


def write_empty_scores(file: Path, grasps: Sequence[str], poses: Sequence[str]) -> None:
    """Write a table with a row per pair of grasp and pose, without counts, for a lab to fill."""
    with file.open("w", encoding="utf-8", newline="") as lines:
        writer = csv.writer(lines, lineterminator="\n")
        writer.writerow(COLUMNS)
        writer.writerows([grasp, pose, "", ""] for grasp in grasps for pose in poses)


def read_scores(file: Path, grasps: Sequence[str], poses: Sequence[str]) -> MeasuredScores | GivenScores:
    """Read a table of scores.

    Args:
        file: CSV with the columns `grasp`, `pose`, `successes`, `attempts`, separated by commas or semicolons.
        grasps, poses: names of the scenario, each pair of which needs a row.

    Returns:
        Measured scores where all pairs have equally many attempts, else the shares of successes.

    Raises:
        InvalidScores: the file cannot be read, a row is invalid or repeated, or a pair has no row.
    """
    counts: dict[tuple[str, str], tuple[int, int]] = {}
    for number, row in _rows(file):
        grasp, pose = row["grasp"], row["pose"]
        for kind, name, known in (("grasp", grasp, grasps), ("pose", pose, poses)):
            if name not in known:
                raise InvalidScores(
                    f"{file}: row {number}, column {kind}: the scenario has no {kind} {name!r}; expected one of "
                    f"{', '.join(map(repr, known))}"
                )
        if (grasp, pose) in counts:
            raise InvalidScores(f"{file}: row {number}: expected one row for grasp {grasp!r} at pose {pose!r}, got two")
        attempts = _count(file, number, row, "attempts", 1, _MOST)
        counts[grasp, pose] = _count(file, number, row, "successes", 0, attempts), attempts
    pairs = [(grasp, pose) for grasp in grasps for pose in poses]
    missing = [f"grasp {grasp!r} at pose {pose!r}" for grasp, pose in pairs if (grasp, pose) not in counts]
    if missing:
        more = f" and {len(missing) - _LISTED} more" if len(missing) > _LISTED else ""
        raise InvalidScores(
            f"{file}: expected a row for each of {len(grasps)} grasps at each of {len(poses)} poses; missing: "
            f"{', '.join(missing[:_LISTED])}{more}"
        )
    numbers = {attempts for _, attempts in counts.values()}
    if len(numbers) == 1:
        successes = [[counts[grasp, pose][0] for pose in poses] for grasp in grasps]
        return MeasuredScores(attempts=numbers.pop(), successes=successes)
    shares = [[counts[grasp, pose][0] / counts[grasp, pose][1] for pose in poses] for grasp in grasps]
    return GivenScores(probabilities=shares)


def _rows(file: Path) -> list[tuple[int, dict[str, str]]]:
    """Rows that are not empty, with their numbers as a spreadsheet counts them; raises InvalidScores."""
    try:
        text = file.read_text(encoding="utf-8-sig")
    except (OSError, UnicodeDecodeError) as error:
        raise InvalidScores(f"{file}: expected a CSV file in UTF-8: {error}") from error
    lines = text.splitlines()
    separator = ";" if lines and ";" in lines[0] else ","
    table = list(csv.reader(lines, delimiter=separator))
    names = [name.strip() for name in table[0]] if table else []
    absent = [name for name in COLUMNS if name not in names]
    if absent:
        raise InvalidScores(f"{file}: row 1: expected the columns {', '.join(COLUMNS)}; missing: {', '.join(absent)}")
    rows = []
    for number, cells in enumerate(table[1:], start=2):
        values = [cell.strip() for cell in cells]
        if not any(values):
            continue
        if len(values) < len(names):
            raise InvalidScores(f"{file}: row {number}: expected {len(names)} columns, got {len(values)}")
        rows.append((number, dict(zip(names, values, strict=False))))
    return rows


def _count(file: Path, number: int, row: dict[str, str], column: str, least: int, most: int) -> int:
    """Read a count from a cell; raises InvalidScores."""
    text = row[column]
    value = int(text) if text.isdecimal() else -1
    if not least <= value <= most:
        where = f"grasp {row['grasp']!r} at pose {row['pose']!r}"
        raise InvalidScores(
            f"{file}: row {number}, column {column}: expected a whole number from {least} to {most} for {where}, got "
            f"{text or 'an empty cell'!r}"
        )
    return value
