"""CSV files and the JSON document of an evaluation of values."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import asdict, fields, is_dataclass
from pathlib import Path
from types import MappingProxyType
from typing import Any

from voa_evaluation.report.tables import Cell, write_csv
from voa_evaluation.statistics import Interval
from voa_evaluation.values import results
from voa_evaluation.values.results import Values

TABLES: Mapping[str, type] = MappingProxyType(
    {
        "looks": results.LookValue,
        "promises": results.Promise,
        "bins": results.Bin,
        "ways": results.WayValue,
        "differences": results.Difference,
        "several": results.SeveralLooks,
        "next_looks": results.NextLookValue,
        "repetitions": results.Repetition,
        "pairs": results.PairValue,
        "driving": results.DrivingValue,
        "two_robots": results.TwoRobots,
        "confirmations": results.Confirmation,
    }
)
"""Tables of an evaluation: the field of `Values`, and the type of its rows."""


def write_tables(folder: Path, values: Values) -> dict[str, Path]:
    """Write a CSV file for each table to a folder, `values-TABLE.csv`; return their paths by the table's name."""
    folder.mkdir(parents=True, exist_ok=True)
    files = {}
    for name, kind in TABLES.items():
        files[name] = folder / f"values-{name.replace('_', '-')}.csv"
        write_csv(files[name], list(_header(kind)), (list(_cells(row)) for row in getattr(values, name)))
    return files


def document(values: Values) -> dict[str, Any]:
    """Make the JSON document: the setting, the counts and every table as a list of objects."""
    return {
        "setting": asdict(values.setting),
        "counts": asdict(values.counts),
        **{name: [asdict(row) for row in getattr(values, name)] for name in TABLES},
    }


def _header(kind: type) -> Iterator[str]:
    """Name the columns of a table; an interval has four: its value, its ends and its count."""
    if not is_dataclass(kind):
        raise TypeError(f"expected a dataclass, got {kind}")
    for field in fields(kind):
        yield field.name
        if "Interval" in str(field.type):
            yield from (f"{field.name}_{part}" for part in ("low", "high", "count"))


def _cells(row: Any) -> Iterator[Cell]:
    for field in fields(row):
        yield from _of_field(getattr(row, field.name), interval="Interval" in str(field.type))


def _of_field(value: Any, *, interval: bool) -> Sequence[Cell]:
    if not interval:
        return [value]
    if isinstance(value, Interval):
        return [value.value, value.low, value.high, value.count]
    return [None] * 4
