"""The command `voa restore`: puts a backup in the place of a database."""

import argparse
from collections.abc import Sequence
from pathlib import Path

from voa_service.backup_command import damages, parsed, run, summary
from voa_store.backups import Restored, restore


def main(arguments: Sequence[str] | None = None) -> int:
    """Put a backup in the place of an SQLite database that no process has open.

    Args:
        arguments: of the command line; None: those of this process.

    Returns:
        The exit code: 0 where the backup was restored, 1 where nothing was changed.
    """
    parser = argparse.ArgumentParser(
        prog="voa restore",
        description="Puts a backup of `voa backup` in the place of an SQLite database, after verifying every session "
        "of it. Stop the service first. The database from before is kept beside it.",
    )
    parser.add_argument("file", type=Path, metavar="FILE", help="the backup")
    parser.add_argument("--even-if-damaged", action="store_true", help="restore a backup with damaged sessions, too")
    options = parsed(parser, arguments)
    return run(
        "restore", options, lambda url: restore(options.file, url, even_if_damaged=options.even_if_damaged), _restored
    )


def _restored(result: Restored) -> list[str]:
    kept = "" if result.kept is None else f"; the database from before is {result.kept}"
    return [f"{result.file}: restored, {summary(result.verified)}{kept}", *damages(result.verified)]
