"""A program that floods a session's key, so that it takes no time from whoever is flooded.

    python -m tests.chaos.flooding ENDPOINT KEY SECONDS < a session as JSON

prints how many samples it has put.
"""

import json
import sys
import time

from zenoh import Encoding

from tests.support.bus import stranger


def main(endpoint: str, key: str, seconds: float) -> int:
    """Put forged versions, garbage and deletes as fast as that goes; returns how many."""
    session = json.load(sys.stdin)
    high = [10**6, 10**12]
    forged = [(json.dumps(session | {"version": version}).encode(), str(version).encode()) for version in high]
    count, end = 0, time.monotonic() + seconds
    with stranger(endpoint) as own:
        while time.monotonic() < end:
            for payload, attachment in (*forged, (b"\0", b"2")):
                own.session.put(key, payload, encoding=Encoding.APPLICATION_JSON, attachment=attachment)
            own.session.delete(key)
            count += len(forged) + 2
    return count


if __name__ == "__main__":
    print(main(sys.argv[1], sys.argv[2], float(sys.argv[3])))
