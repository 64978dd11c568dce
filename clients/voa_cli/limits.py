"""Limits of the messages that commands read, as the service's settings have them."""

import os

from voa_client import VoaClientError
from voa_ros.cdr import MOST_BEAMS

BEAMS = "VOA_LIMITS__BEAMS"


def most_beams() -> int:
    """Beams that a scan may have: `VOA_LIMITS__BEAMS` of the environment, as for `voa serve`; raises VoaClientError."""
    text = os.environ.get(BEAMS, str(MOST_BEAMS))
    if not text.isascii() or not text.isdigit() or int(text) < 1:
        raise VoaClientError(f"{BEAMS}: expected a whole number from 1, got {text!r}")
    return int(text)
