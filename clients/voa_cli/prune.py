"""`voa prune`: delete the sessions of a service that have not moved for long, with their histories."""

import argparse
import json
import re
import sys
from collections.abc import Sequence
from datetime import UTC, datetime, timedelta

from voa_client import Client, NotFoundError, StaleVersionError, VoaClientError
from voa_client.local import BRIEFLY
from voa_msgs.sessions import SessionSummary

DEFAULT_URL = "http://127.0.0.1:8000"
_UNITS = {"h": "hours", "d": "days", "w": "weeks"}
_AGE = re.compile(r"(\d+(?:\.\d+)?)([hdw])")


def main(arguments: Sequence[str] | None = None) -> int:
    """Delete old sessions and return 0; 1 after an error."""
    options = _parser().parse_args(arguments)
    try:
        with Client(options.url, retries=BRIEFLY) as client:
            _prune(client, options)
    except VoaClientError as error:
        print(f"voa prune: {error}", file=sys.stderr)
        return 1
    return 0


def age(text: str) -> timedelta:
    """Read an age such as 30d, 12h or 6w; raises ArgumentTypeError."""
    match = _AGE.fullmatch(text)
    if match is None:
        raise argparse.ArgumentTypeError(f"expected a number with h, d or w, as in 12h, 30d or 6w; got {text!r}")
    try:
        return timedelta(**{_UNITS[match[2]]: float(match[1])})
    except OverflowError as error:
        raise argparse.ArgumentTypeError(f"expected fewer than 999999999 days, got {text!r}") from error


def _prune(client: Client, options: argparse.Namespace) -> None:
    before = datetime.now(UTC) - options.older_than
    old = [session for session in client.list_sessions() if session.updated_at < before]
    deleted = old if options.dry_run else [session for session in old if _is_deleted(client, session)]
    if options.json:
        print(json.dumps({"sessions": [session.id for session in deleted], "dry_run": options.dry_run}))
        return
    for session in deleted:
        print(f"{session.id}  version {session.version}, last moved {session.updated_at:%Y-%m-%d %H:%M}")
    what = "would be deleted" if options.dry_run else "deleted"
    count = f"{len(deleted)} session{'' if len(deleted) == 1 else 's'}"
    print(f"{count} {what}: last moved before {before:%Y-%m-%d %H:%M} UTC")


def _is_deleted(client: Client, session: SessionSummary) -> bool:
    """Delete a session unless it has moved meanwhile; True if it was deleted."""
    try:
        client.delete_session(session.id, if_match=session.version)
    except (StaleVersionError, NotFoundError):
        return False
    return True


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(
        prog="voa prune",
        description="Deletes the sessions of a service that have not moved for a time, with their histories and stored "
        "responses, for good. A session that moves meanwhile stays.",
    )
    parser.add_argument(
        "--older-than", type=age, required=True, metavar="AGE", help="time since the newest version: 12h, 30d, 6w"
    )
    parser.add_argument("--dry-run", action="store_true", help="list the sessions, and delete none")
    parser.add_argument("--json", action="store_true", help="print one JSON document")
    parser.add_argument("--url", default=DEFAULT_URL, help="of the service, over HTTP; default: %(default)s")
    return parser
