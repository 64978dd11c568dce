"""The process `python -m voa_service.local`: one document in, lines of JSON out."""

import argparse
import json
import signal
import sys
import threading
from collections.abc import Sequence
from pathlib import Path
from typing import IO, NoReturn

from pydantic import ValidationError
from pydantic_settings import SettingsError

from voa_service.failures import Failure, document
from voa_service.guard import guarded
from voa_service.local.distributing import distribution
from voa_service.local.document import read_document
from voa_service.local.ranking import LocalRanking, local_services, ranked
from voa_service.runtime import logs
from voa_service.runtime.queues import Cancelled
from voa_service.settings import Settings

_INTERRUPTED = 130


def main(arguments: Sequence[str] | None = None) -> int:
    """Rank the looks of the document on standard input.

    Returns:
        The exit status: 0 after a result, 1 after a problem, 2 for a wrong setting, 130 after an interrupt.
    """
    options = _parser().parse_args(arguments)
    try:
        settings = Settings()
    except (ValidationError, SettingsError) as error:
        print(f"voa_service.local: {error}", file=sys.stderr)
        return 2
    logs.configure("WARNING")
    signal.signal(signal.SIGTERM, _interrupt)
    signal.signal(signal.SIGINT, _interrupt)
    try:
        return _answered(sys.stdin.buffer.read(), settings, options, sys.stdout)
    except KeyboardInterrupt:
        return _INTERRUPTED


def _answered(content: bytes, settings: Settings, options: argparse.Namespace, out: IO[str]) -> int:
    """Write the lines about one document, and return the exit status."""
    try:
        with guarded():
            result = _result(content, settings, options, out)
    except Failure as failure:
        print(f'{{"problem":{document(failure).decode()}}}', file=out, flush=True)
        return 1
    warnings = json.dumps([warning.model_dump(mode="json", exclude_unset=True) for warning in result.warnings])
    print(f'{{"result":{{"warnings":{warnings},"ranking":{result.body.decode()}}}}}', file=out, flush=True)
    return 0


def _result(content: bytes, settings: Settings, options: argparse.Namespace, out: IO[str]) -> LocalRanking:
    """Rank as the document says, and write a line for each finished part."""
    ended = threading.Event()

    def check() -> None:
        if ended.is_set():
            raise Cancelled

    def report(done: int, total: int) -> None:
        print(json.dumps({"progress": {"done": done, "total": total}}), file=out, flush=True)

    given = read_document(content)
    with local_services(settings) as built, distribution(options.cluster, options.resume, report) as distribute:
        try:
            return ranked(built, given, distribute, check)
        finally:
            ended.set()  # threads that still work on parts end at their next check


def _interrupt(*_: object) -> NoReturn:
    """End as after Ctrl-C; further signals do not disturb the end."""
    signal.signal(signal.SIGTERM, signal.SIG_IGN)
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    raise KeyboardInterrupt


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(
        prog="python -m voa_service.local",
        description="Rank the looks of the document on standard input; writes lines of JSON (see voa_service.local).",
    )
    parser.add_argument("--cluster", help="scheduler of dask.distributed (tcp://HOST:PORT), or local[:N] processes")
    parser.add_argument("--resume", type=Path, metavar="DIR", help="folder that keeps the results of finished parts")
    return parser
