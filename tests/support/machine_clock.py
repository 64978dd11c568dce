"""Wall clock of one process, which a test sets while the process runs, by libfaketime (Debian's `faketime`)."""

import os
from pathlib import Path

HOW_TO_INSTALL = "libfaketime is not installed; on Debian: apt-get install faketime"


class MachineClock:
    """Wall clock of one process; its other clocks, by which it waits, are never set.

    Args:
        file: that states by how much the clock is wrong; it is made.

    Raises:
        FileNotFoundError: libfaketime is not installed; the error says how to install it.
    """

    def __init__(self, file: Path) -> None:
        library = next(iter(sorted(Path("/usr/lib").glob("*/faketime/libfaketimeMT.so.1"))), None)
        if library is None:
            raise FileNotFoundError(HOW_TO_INSTALL)
        self._file = file
        self.set(0)
        self.environment = dict(os.environ) | {
            "LD_PRELOAD": str(library),
            "FAKETIME_TIMESTAMP_FILE": str(file),
            "FAKETIME_NO_CACHE": "1",
            "FAKETIME_DONT_FAKE_MONOTONIC": "1",
            "NO_FAKE_STAT": "1",
        }

    def set(self, ahead_s: float) -> None:
        """Set the clock ahead of the real one, or behind it (less than 0), seconds."""
        beside = self._file.with_suffix(".new")
        beside.write_text(f"{ahead_s:+.0f}\n")
        beside.replace(self._file)
