"""`voa keys`: make, list and revoke the API keys of a service, in its database.

voa keys create tb3_1 --role sensor            makes a key and prints it, once
voa keys create anna --role operator -o FILE   writes it into a new file that only you can read
voa keys list                                  the keys that are valid, with their last use
voa keys revoke ID...                          ends keys for good

Roles: sensor (sends scans, announces looks, reads), arm (reports outcomes of grasps, reads), viewer (reads, rankings
included), operator (everything).

The first key closes the service to callers without a key, for good. A running service notices a new or revoked key
within about 2 s, in all its processes. To replace a key: make another one of the same name, give it to the robot, see
in the list that the old one is no longer used, and revoke the old one.

A line on stderr, of the form of the service's audit, says who made or revoked a key.
"""

import argparse
import getpass
import os
import re
import sys
from collections.abc import Callable, Sequence
from contextlib import closing
from datetime import UTC, datetime
from functools import partial
from pathlib import Path

from pydantic import ValidationError
from pydantic_settings import SettingsError

from voa_service.access.audit import record_key
from voa_service.access.keyring import REFRESH_SECONDS
from voa_service.access.keys import PREFIX, id_of, new_key
from voa_service.access.listing import as_json, as_table, duration
from voa_service.access.roles import ROLES
from voa_service.runtime.logs import logger_of_command
from voa_service.settings import Settings
from voa_store.errors import StoreError
from voa_store.keys import KeyStore
from voa_store.records import StoredKey
from voa_store.starting import open_keys

_NAME = re.compile(r"[A-Za-z0-9_.-]{1,64}")


class Refused(Exception):
    """A command that cannot be done; the message says why."""


def main(arguments: Sequence[str] | None = None) -> int:
    """Run a subcommand and return 0; 1 after an error, 2 for a wrong setting."""
    options = _parser().parse_args(arguments)
    try:
        settings = Settings() if options.database_url is None else Settings(database_url=options.database_url)
    except (ValidationError, SettingsError) as error:
        print(f"voa keys: {error}", file=sys.stderr)
        return 2
    try:
        with closing(open_keys(settings.database_url, settings.database_patience_s)) as store:
            options.record = partial(record_key, by=_person(), log=logger_of_command(settings.log_level, sys.stderr))
            options.act(store, options, datetime.now(UTC))
    except (StoreError, Refused) as error:
        print(f"voa keys: {error}", file=sys.stderr)
        return 1
    return 0


def _create(store: KeyStore, options: argparse.Namespace, now: datetime) -> None:
    """Make a key; raises Refused."""
    if not _NAME.fullmatch(options.name):
        raise Refused(f"expected a name of letters, digits, '_', '.', '-', at most 64, got {options.name!r}")
    before = store.list_keys()
    others = {key.role for key in before if key.name == options.name and key.is_active(now)} - {options.role}
    if others:
        raise Refused(
            f"there is a key {options.name!r} with the role {others.pop()}: choose another name, or revoke it first"
        )
    made = new_key()
    key = StoredKey(
        id=made.id,
        digest=made.digest,
        name=options.name,
        role=options.role,
        created_at=now,
        sessions=None if options.session is None else tuple(options.session),
        robots=None if options.robot is None else tuple(options.robot),
        expires_at=None if options.expires_in is None else now + options.expires_in,
    )
    if options.out is None:
        store.put_key(key)
        print(made.text)
    else:
        _write(options.out, made.text)
        try:
            store.put_key(key)
        except BaseException:
            options.out.unlink()
            raise
    options.record("key.create", key)
    where = "it is shown this once" if options.out is None else f"it is in {options.out}"
    print(f"voa keys: made key {made.id} ({key.name}, {key.role}); {where}", file=sys.stderr)
    if not before:
        print("voa keys: this first key closes the service to callers without a key, for good", file=sys.stderr)


def _write(file: Path, text: str) -> None:
    """Write a key into a new file that only its owner can read; raises Refused."""
    try:
        with os.fdopen(os.open(file, os.O_WRONLY | os.O_CREAT | os.O_EXCL, 0o600), "w") as opened:
            opened.write(f"{text}\n")
    except OSError as error:
        raise Refused(f"cannot write {file}: {error.strerror}; expected a new file") from error


def _list(store: KeyStore, options: argparse.Namespace, now: datetime) -> None:
    every = store.list_keys()
    keys = every if options.all else [key for key in every if key.is_active(now)]
    if options.json:
        print(as_json(keys, now))
    elif keys:
        print(as_table(keys, now))
    elif every:
        print("no key is valid: the service refuses every caller; --all shows the revoked and expired ones")
    else:
        print("there are no keys: the service answers everybody who reaches it, unless it runs with VOA_REQUIRE_KEYS=1")


def _revoke(store: KeyStore, options: argparse.Namespace, now: datetime) -> None:
    """Revoke keys, if all of them can be; raises Refused."""
    keys = {key.id: key for key in store.list_keys()}
    ids = list(dict.fromkeys(_id(given) for given in options.id))
    for id_ in ids:
        if id_ not in keys:
            raise Refused(f"there is no key {id_!r}; nothing was revoked: `voa keys list --all` lists them")
    for id_ in ids:
        key = keys[id_]
        done = store.revoke_key(id_, now)
        if done:
            options.record("key.revoke", key)
        what = "revoked" if done else "was revoked before:"
        print(f"{what} {id_} ({key.name}, {key.role})")
    print(f"voa keys: running processes refuse it within about {REFRESH_SECONDS:g} s", file=sys.stderr)
    if not any(key.is_active(now) for id_, key in keys.items() if id_ not in ids):
        print("voa keys: no key is valid any more: the service refuses every caller", file=sys.stderr)


def _person() -> str:
    """Return the name of the user that runs this process; where it has none, as in a container, the number."""
    try:
        return getpass.getuser()
    except (OSError, KeyError):
        return f"user {os.getuid()}"


def _id(given: str) -> str:
    """Return the id of a key as a person gives it; raises Refused for the key itself."""
    if id_of(given) is not None:
        raise Refused("expected the id of a key, not the key: others can see the command line, and shells keep it")
    return given.removeprefix(f"{PREFIX}_")


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(
        prog="voa keys", description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    commands = parser.add_subparsers(required=True, metavar="create | list | revoke")

    def command(
        name: str, act: Callable[[KeyStore, argparse.Namespace, datetime], None], help_: str
    ) -> argparse.ArgumentParser:
        one = commands.add_parser(name, help=help_)
        one.add_argument(
            "--database-url", help="database of the service (default VOA_DATABASE_URL, else sqlite:///voa.db)"
        )
        one.set_defaults(act=act)
        return one

    create = command("create", _create, "make a key and print it, once")
    create.add_argument("name", help="name of the caller, such as that of the robot or person")
    create.add_argument("--role", required=True, choices=ROLES, help="role of the caller")
    create.add_argument("--session", action="append", metavar="ID", help="only for this session; may be repeated")
    create.add_argument("--robot", action="append", metavar="NAME", help="only for this robot; may be repeated")
    create.add_argument("--expires-in", type=_duration, metavar="TIME", help="valid for so long, as in 90d or 12h")
    create.add_argument("-o", "--out", type=Path, metavar="FILE", help="write the key into this new file instead")
    listing = command("list", _list, "list the valid keys")
    listing.add_argument("--all", action="store_true", help="revoked and expired keys, too")
    listing.add_argument("--json", action="store_true", help="print one JSON document")
    revoke = command("revoke", _revoke, "end keys for good")
    revoke.add_argument("id", nargs="+", help="id of a key, as the list shows it")
    return parser


def _duration(text: str) -> object:
    try:
        return duration(text)
    except ValueError as error:
        raise argparse.ArgumentTypeError(str(error)) from error
