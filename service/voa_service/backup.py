"""The command `voa backup`: copies the database of a running service to a file."""

import argparse
from collections.abc import Sequence
from pathlib import Path

from voa_service.backup_command import damages, parsed, run, summary
from voa_store.backups import BackedUp, back_up


def main(arguments: Sequence[str] | None = None) -> int:
    """Back up an SQLite database while the service runs, and verify the copy.

    Args:
        arguments: of the command line; None: those of this process.

    Returns:
        The exit code: 0 where the backup is written and undamaged, 1 where it is damaged or cannot be written.
    """
    parser = argparse.ArgumentParser(
        prog="voa backup",
        description="Copies an SQLite database to a file while the service runs, and verifies every session of the "
        "copy. For PostgreSQL, use pg_dump.",
    )
    parser.add_argument("file", type=Path, metavar="FILE", help="the backup")
    parser.add_argument("--replace", action="store_true", help="replace a file of that name")
    options = parsed(parser, arguments)
    return run("backup", options, lambda url: back_up(url, options.file, replace=options.replace), _backed_up)


def _backed_up(result: BackedUp) -> list[str]:
    return [f"{result.file}: {result.size / 1e6:.1f} MB, {summary(result.verified)}", *damages(result.verified)]
