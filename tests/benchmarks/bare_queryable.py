"""The peer of the bus's benchmark: a Zenoh queryable that answers the same bytes to everything, and does no work."""

import json
import signal
import sys

import zenoh
from zenoh import Encoding
from zenoh.handlers import Callback

from voa_msgs.links import session_config

KEY = "bare/echo"


def main() -> None:
    """`python -m tests.benchmarks.bare_queryable ENDPOINT BYTES`: serve until a signal ends it."""
    config = zenoh.Config()
    for path, value in session_config([sys.argv[1]], open_ms=10_000).items():
        config.insert_json5(path, json.dumps(value))
    answer = b"x" * int(sys.argv[2])

    def on(query: zenoh.Query) -> None:
        with query:
            query.reply(query.key_expr, answer, encoding=Encoding.APPLICATION_JSON)

    signal.signal(signal.SIGTERM, lambda *_: sys.exit(0))
    with zenoh.open(config) as session, session.declare_queryable(KEY, Callback(on, indirect=False), complete=True):
        print("listening", flush=True)
        signal.pause()


if __name__ == "__main__":
    main()
