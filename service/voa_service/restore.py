"""The command `voa restore`: puts a backup in the place of a database."""

import argparse
from collections.abc import Sequence
from pathlib import Path

from voa_service.backup_command import damages, parsed, run, summary
from voa_store.backups import Restored, restore
from voa_store.carrying import CarriedKeys


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
        "of it. Stop the service first. The database from before is kept beside it; its API keys and their revocations "
        "stay in force.",
    )
    parser.add_argument("file", type=Path, metavar="FILE", help="the backup")
    parser.add_argument("--even-if-damaged", action="store_true", help="restore a backup with damaged sessions, too")
    options = parsed(parser, arguments)
    return run(
        "restore", options, lambda url: restore(options.file, url, even_if_damaged=options.even_if_damaged), _restored
    )


def _restored(result: Restored) -> list[str]:
    kept = "" if result.kept is None else f"; the database from before is {result.kept}"
    restored = f"{result.file}: restored, {summary(result.verified)}{kept}"
    return [restored, *damages(result.verified), *_keys(result.keys)]


def _keys(keys: CarriedKeys) -> list[str]:
    """Explain which keys are valid after the restoration; no line where there was never a key."""
    valid = f"{keys.unrevoked} of {keys.all} keys are not revoked"
    check = "see `voa keys list`, and revoke those that were revoked since the backup"
    if keys.before == "unreadable":
        unread = "keys: those of the database from before cannot be read"
        if keys.all:
            return [f"{unread}; {valid}: {check}"]
        return [f"{unread}, and the backup has none: start the service with VOA_REQUIRE_KEYS=1, or make a key first"]
    if not keys.all:
        return []
    if keys.before == "none":
        return [f"keys: those of the backup, for there was no database before; {valid}: {check}"]
    return [
        f"keys: {keys.carried} carried over from the database before, {keys.revoked} of the backup revoked as there; "
        f"{valid}"
    ]
