"""The records of a PLY file, as text or as bytes."""

from dataclasses import dataclass, field, replace
from struct import Struct
from typing import Any

import numpy as np

from voa_meshes.ply_header import Element
from voa_meshes.text import numbers, shown, with_newlines
from voa_meshes.triangles import Floats, Indices, UnreadableMesh

_PADDING = b"\0\x1a \t\r\n"


@dataclass(frozen=True, eq=False)
class Records:
    """The values of an element's records, by property.

    Attributes:
        single: by property, its values (n,).
        lists: by property, how many values each list has (n,), and all of them one after the other.
    """

    single: dict[str, Floats] = field(default_factory=dict)
    lists: dict[str, tuple[Indices, Floats]] = field(default_factory=dict)


class TextRecords:
    """Reads records from text, one from each line."""

    def __init__(self, data: bytes) -> None:
        self._lines = [line for line in with_newlines(data).split(b"\n") if line and not line.isspace()]
        self._at = 0

    def take(self, element: Element) -> Records:
        """Read the records of the next element; raises UnreadableMesh if there are fewer."""
        rows = self._lines[self._at : self._at + element.count]
        if len(rows) < element.count:
            raise _too_few(element, len(rows))
        self._at += element.count
        columns = _Columns(element)
        for number, row in enumerate(rows, 1):
            try:
                columns.add(numbers(row.split()))
            except ValueError as error:
                raise UnreadableMesh(
                    f"{element.name} {number}: expected the header's values, got {shown(row)}"
                ) from error
        return columns.records()

    def one_more(self, element: Element) -> Records | None:
        """Read one more record than the header announced; None where the data end, or are no record."""
        columns = _Columns(element)
        try:
            for line in self._lines[self._at : self._at + 1]:
                columns.add(numbers(line.split()))
        except ValueError:
            return None
        return columns.records() if self._at < len(self._lines) else None


class _Columns:
    """The values of records that are added one by one."""

    def __init__(self, element: Element) -> None:
        self._properties = element.properties
        self._values: list[list[float]] = [[] for _ in element.properties]
        self._sizes: list[list[int]] = [[] for _ in element.properties]

    def add(self, row: list[float]) -> None:
        """Add one record; raises ValueError where it has too few or too many values."""
        at = 0
        for property_, column, sizes in zip(self._properties, self._values, self._sizes, strict=True):
            size = 1
            if property_.counted_by is not None:
                size = int(row[at]) if at < len(row) and row[at].is_integer() and row[at] >= 0.0 else len(row)
                sizes.append(size)
                at += 1
            column.extend(row[at : at + size])
            at += size
        if at != len(row):
            raise ValueError("a record of another length")

    def records(self) -> Records:
        """Return the records that were added."""
        records = Records()
        for property_, values, sizes in zip(self._properties, self._values, self._sizes, strict=True):
            column = np.array(values, dtype=np.float64)
            if property_.counted_by is None:
                records.single[property_.name] = column
            else:
                records.lists[property_.name] = np.array(sizes, dtype=np.int64), column
        return records


class BytesRecords:
    """Reads binary records, in the byte order that numpy writes as `<` or `>`."""

    def __init__(self, data: bytes, order: str) -> None:
        self._data, self._order, self._at = data, order, 0

    def take(self, element: Element) -> Records:
        """Read the records of the next element; raises UnreadableMesh if there are fewer."""
        alike = self._alike(element) if element.count > 1 else None
        return self._walked(element) if alike is None else alike

    def one_more(self, element: Element) -> Records | None:
        """Read one more record than the header announced; None where the rest is padding, or no record."""
        if not self._data[self._at :].strip(_PADDING):
            return None
        try:
            return self.take(replace(element, count=1))
        except UnreadableMesh:
            return None

    def _alike(self, element: Element) -> Records | None:
        """Read the records of an element at once; None unless their lists are all as long as those of the first."""
        begin = self._at
        first = self._walked(replace(element, count=1))
        self._at = begin
        fields: list[tuple[Any, ...]] = []
        for property_ in element.properties:
            if property_.counted_by is None:
                fields.append((property_.name, self._order + property_.type))
            else:
                fields.append((f"#{property_.name}", self._order + property_.counted_by))
                fields.append((property_.name, self._order + property_.type, (int(first.lists[property_.name][0][0]),)))
        dtype = np.dtype(fields)
        if begin + element.count * dtype.itemsize > len(self._data):
            return None
        rows = np.frombuffer(self._data, dtype, element.count, begin)
        records = Records()
        for property_ in element.properties:
            column = rows[property_.name].astype(np.float64)
            if property_.counted_by is None:
                records.single[property_.name] = column
                continue
            sizes = rows[f"#{property_.name}"].astype(np.int64)
            if (sizes != sizes[0]).any():
                return None
            records.lists[property_.name] = sizes, column.reshape(-1)
        self._at += rows.nbytes
        return records

    def _walked(self, element: Element) -> Records:
        """Read the records of an element one after the other."""
        layout = [
            (
                None if each.counted_by is None else Struct(self._order + np.dtype(each.counted_by).char),
                np.dtype(self._order + each.type),
            )
            for each in element.properties
        ]
        values: list[list[bytes]] = [[] for _ in layout]
        sizes: list[list[int]] = [[] for _ in layout]
        at = self._at
        for number in range(element.count):
            for column, (counter, type_) in enumerate(layout):
                size = 1
                if counter is not None:
                    size = int(counter.unpack_from(self._data, at)[0]) if at + counter.size <= len(self._data) else -1
                    sizes[column].append(size)
                    at += counter.size
                end = at + size * type_.itemsize
                if size < 0 or end > len(self._data):
                    raise _too_few(element, number)
                values[column].append(self._data[at:end])
                at = end
        self._at = at
        records = Records()
        for each, (_, type_), pieces, lengths in zip(element.properties, layout, values, sizes, strict=True):
            read = np.frombuffer(b"".join(pieces), type_).astype(np.float64)
            if each.counted_by is None:
                records.single[each.name] = read
            else:
                records.lists[each.name] = np.array(lengths, dtype=np.int64), read
        return records


def _too_few(element: Element, count: int) -> UnreadableMesh:
    return UnreadableMesh(f"the header says {element.count} of {element.name!a}, the file has {count}: is it cut off?")
