"""Faults of the disk below a process of the service: errors, a full disk, torn and lost writes, flipped bits.

A library of `storage_faults.c`, compiled by the test, is loaded before the others into the process. The test states
the faults by a file that both share, while the process runs.
"""

import mmap
import os
import shutil
import struct
import subprocess
from collections.abc import Iterator
from contextlib import contextmanager
from enum import IntEnum, IntFlag
from pathlib import Path

_SOURCE = Path(__file__).with_name("storage_faults.c")
_FIELDS = struct.Struct("5i")
_WITHOUT_END = 2**30
HOW_TO_INSTALL = "a C compiler is needed; on Debian: apt-get install gcc libc6-dev"


class On(IntFlag):
    """Calls of the system that a fault concerns."""

    WRITE = 1
    SYNC = 2
    READ = 4
    TRUNCATE = 8


class How(IntEnum):
    """Kinds of faults.

    EIO and FULL are errors that the call returns. SHORT writes half, and reports so. TORN writes half and kills the
    process. FLIPPED changes one bit of what is written or read, and LOST writes nothing; neither is reported.
    """

    EIO = 0
    FULL = 1
    SHORT = 2
    TORN = 3
    FLIPPED = 4
    LOST = 5


class Disk:
    """Disk of a process, which can have faults.

    Args:
        control: file that is shared with the process.
        environment: variables of the process.
    """

    def __init__(self, control: Path, environment: dict[str, str]) -> None:
        self.environment = environment
        control.write_bytes(bytes(_FIELDS.size))
        with control.open("r+b") as file:
            self._shared = mmap.mmap(file.fileno(), _FIELDS.size)

    def fail(self, on: On, how: How, *, skip: int = 0, times: int = _WITHOUT_END) -> None:
        """Let calls fail, after `skip` more of them, `times` times."""
        self._shared[:] = _FIELDS.pack(0, how, skip, times, 0)
        self._shared[: struct.calcsize("i")] = struct.pack("i", on)

    def mend(self) -> int:
        """End the faults; returns how many there were."""
        happened = self.happened
        self._shared[:] = bytes(_FIELDS.size)
        return happened

    @property
    def happened(self) -> int:
        """Number of faults since `fail`."""
        return int(_FIELDS.unpack(self._shared[:])[4])

    def close(self) -> None:
        """Release the shared file."""
        self._shared.close()


@contextmanager
def faulty_disk(folder: Path, files: Path, name: str = "disk") -> Iterator[Disk]:
    """Compile the library, and make the disk of one process.

    Args:
        folder: for the library.
        files: beginning of the paths of the files that may have faults.
        name: of the disk, of which a folder may have several.

    Raises:
        FileNotFoundError: there is no C compiler; the error says how to install it.
    """
    library, control = folder / "storage_faults.so", folder / f"{name}.faults"
    if not library.exists():
        compiler = shutil.which("cc") or shutil.which("gcc")
        if compiler is None:
            raise FileNotFoundError(HOW_TO_INSTALL)
        flags = ["-shared", "-fPIC", "-O1", "-Wall", "-Werror"]
        subprocess.run([compiler, *flags, "-o", str(library), str(_SOURCE), "-ldl"], check=True, capture_output=True)
    disk = Disk(
        control,
        dict(os.environ)
        | {"LD_PRELOAD": str(library), "DISK_FAULTS_CONTROL": str(control), "DISK_FAULTS_FILES": str(files)},
    )
    try:
        yield disk
    finally:
        disk.close()
