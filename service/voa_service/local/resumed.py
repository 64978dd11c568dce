"""A map over the parts of a ranking that keeps its results in a folder, and computes none of them twice."""

import hashlib
import itertools
import json
import os
import pickle
from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import TypeVar

from voa_service.mapping.rankings import ParallelMap

A = TypeVar("A")
B = TypeVar("B")


@dataclass(frozen=True)
class ResumedMap:
    """A `map` that works as another one does, and keeps each result in a file of its own.

    A ranking maps over its parts several times, each time in the same order; the results of each time have a folder.

    Attributes:
        parallel_map: applies the function to the items whose results are not kept yet.
        folder: of this ranking, see `folder_of`; its files are read by `pickle`, so it must be one's own.
    """

    parallel_map: ParallelMap
    folder: Path
    _times: Iterator[int] = field(default_factory=itertools.count, repr=False)

    def __call__(self, function: Callable[[A], B], items: Iterable[A], /) -> Iterator[B]:
        """Return the results in the order of the items.

        Raises:
            OSError: the folder cannot be read or written.
        """
        folder = self.folder / str(next(self._times))
        folder.mkdir(parents=True, exist_ok=True)
        return self._results(function, list(items), folder)

    def _results(self, function: Callable[[A], B], items: list[A], folder: Path) -> Iterator[B]:
        files = [folder / f"{index}.pickle" for index in range(len(items))]
        kept = [file.is_file() for file in files]
        missing = [item for item, is_kept in zip(items, kept, strict=True) if not is_kept]
        computed = iter(self.parallel_map(function, missing) if missing else [])
        for file, is_kept in zip(files, kept, strict=True):
            if is_kept:
                yield pickle.loads(file.read_bytes())  # noqa: S301 - a file of the user's own
            else:
                result = next(computed)
                _write(file, pickle.dumps(result))
                yield result


def folder_of(parent: Path, ranking: Mapping[str, str]) -> Path:
    """Name the folder of a ranking: by a digest of everything on which its results depend."""
    return parent / hashlib.sha256(json.dumps(ranking, sort_keys=True).encode()).hexdigest()


def _write(file: Path, content: bytes) -> None:
    """Write a file that is there in full or not at all, whenever the process ends."""
    part = file.with_suffix(".part")
    part.write_bytes(content)
    os.replace(part, file)
