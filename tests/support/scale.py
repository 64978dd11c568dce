"""Scale of the long tests: `VOA_TEST_SCALE` is "small" in CI and "full" for acceptance."""

import os
from typing import TypeVar

T = TypeVar("T")

SCALES = ("small", "full")
SCALE = os.environ.get("VOA_TEST_SCALE", "small")
if SCALE not in SCALES:
    raise ValueError(f"VOA_TEST_SCALE: expected one of {', '.join(SCALES)}, got {SCALE!r}")


def scaled(small: T, full: T) -> T:
    """Return the value for the scale of this run."""
    return full if SCALE == "full" else small
