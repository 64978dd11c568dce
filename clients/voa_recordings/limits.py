"""Limits that commands share with `voa serve`, by the same variables of the environment."""

import os
from collections.abc import Mapping

from voa_client import VoaClientError
from voa_ros.cdr import MOST_BEAMS

BEAMS = "VOA_LIMITS__BEAMS"


class InvalidLimit(VoaClientError):
    """A limit in the environment that is no positive whole number."""


def most_beams(environment: Mapping[str, str] = os.environ) -> int:
    """How many beams a scan may have: `VOA_LIMITS__BEAMS`, as for `voa serve`; 4096 where it is not set.

    Raises:
        InvalidLimit: it is no positive whole number.
    """
    told = environment.get(BEAMS)
    if told is None:
        return MOST_BEAMS
    try:
        beams = int(told)
    except ValueError:
        beams = 0
    if beams < 1:
        raise InvalidLimit(f"{BEAMS}: expected a positive whole number of beams, got {told!r}")
    return beams
