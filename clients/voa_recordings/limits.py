"""Limits that commands share with `voa serve`, from the same environment variables."""

import os
from collections.abc import Mapping

from voa_client import VoaClientError
from voa_ros.cdr import MOST_BEAMS

BEAMS = "VOA_LIMITS__BEAMS"


class InvalidLimit(VoaClientError):
    """A limit in the environment is not a positive whole number."""


def most_beams(environment: Mapping[str, str] = os.environ) -> int:
    """Return the largest number of beams of a scan: `VOA_LIMITS__BEAMS`, as for `voa serve`, or 4096 if it is not set.

    Raises:
        InvalidLimit: the variable is not a positive whole number.
    """
    text = environment.get(BEAMS)
    if text is None:
        return MOST_BEAMS
    try:
        beams = int(text)
    except ValueError:
        beams = 0
    if beams < 1:
        raise InvalidLimit(f"{BEAMS}: expected a positive whole number of beams, got {text!r}")
    return beams
