"""Shared by the commands `voa backup` and `voa restore`: options, errors in one line, and the result in words."""

import argparse
import json
import logging
import sys
from collections.abc import Callable, Sequence
from dataclasses import asdict
from typing import Any

import structlog

from voa_service.settings import Settings
from voa_store.backups import BackedUp, CannotBackUp, Restored
from voa_store.starting import explain
from voa_store.verify import Verified


def parsed(parser: argparse.ArgumentParser, arguments: Sequence[str] | None) -> argparse.Namespace:
    """Parse a command line, with the options that both commands have."""
    parser.add_argument(
        "--database-url", metavar="URL", help="the database; default: VOA_DATABASE_URL, else that of `voa serve`"
    )
    parser.add_argument("--json", action="store_true", help="print one JSON document")
    return parser.parse_args(arguments)


def run(
    name: str,
    options: argparse.Namespace,
    act: Callable[[str], BackedUp | Restored],
    lines: Callable[[Any], Sequence[str]],
) -> int:
    """Run a command and print its result; returns the exit code.

    Args:
        name: of the command.
        options: parsed by `parsed`.
        act: does the work on the database of a URL.
        lines: writes the result for a person.
    """
    structlog.configure(wrapper_class=structlog.make_filtering_bound_logger(logging.CRITICAL))
    url = options.database_url or Settings().database_url
    try:
        result = act(url)
    except CannotBackUp as error:
        return _failed(name, str(error))
    except Exception as error:  # a person reads one line, whatever is wrong with a database
        return _failed(name, str(error) if isinstance(error, ValueError) else explain(error, url))
    if options.json:
        print(json.dumps(asdict(result), default=str))
    else:
        print("\n".join(lines(result)))
    return int(not result.verified.well)


def _failed(name: str, why: str) -> int:
    print(f"voa {name}: {why}", file=sys.stderr)
    return 1


def summary(verified: Verified) -> str:
    """Write the number of sessions and versions that were read, and whether they are undamaged."""
    state = "all undamaged" if verified.well else "DAMAGED"
    return f"{verified.sessions} sessions with {verified.versions} versions, {state}"


def damages(verified: Verified) -> list[str]:
    """Write a line for each damaged session, object and page."""
    sessions = [f"session {damage.session}, version {damage.version}: {damage.detail}" for damage in verified.damaged]
    sessions += [f"object {id_}: it differs from what was written" for id_ in verified.objects]
    return sessions + [f"page of the file: {line}" for line in verified.pages]
