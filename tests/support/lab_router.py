"""Router of a lab with the access list that deploy/zenoh/make_access.py writes, and clients that log in to it."""

import importlib
import json
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import zenoh
from zenoh.handlers import Callback

from tests.support.certificates import Authority
from tests.support.routers import Router, router
from voa_msgs.links import session_config

FOLDER = Path(__file__).resolve().parents[2] / "deploy" / "zenoh"
LAB = """
root = "voa/v1/lab7"
login = "{login}"

[files]
ca = "{folder}/ca.pem"
certificate = "{folder}/router.pem"
key = "{folder}/router.key"
passwords = "{folder}/passwords"

[service]
name = "service"
publishes = ["goal_pose"]

[[robot]]
name = "tb3_1"
receives = ["tb3_1/cmd_vel"]

[[robot]]
name = "tb3_2"
domain = 7

[[arm]]
name = "ur5e"

[[viewer]]
name = "console"

[[viewer]]
name = "recorder"
receives = ["tb3_1/**"]
scans = true

[[viewer]]
name = "rviz"
publishes = ["initialpose"]
"""
NAMES = ("service", "tb3_1", "tb3_2", "ur5e", "console", "recorder", "rviz")

OBSERVER = "observer"
"""Client of the tests, which the router allows everything: it sees what the router let pass from others."""
MARKERS = "marker/**"
"""Keys on which everyone is allowed everything: when a marker has arrived, so has all that was sent before."""
MESSAGES = [
    "put",
    "delete",
    "declare_subscriber",
    "query",
    "reply",
    "declare_queryable",
    "liveliness_token",
    "liveliness_query",
    "declare_liveliness_subscriber",
]


def admit_observer(access: dict[str, Any], proved_by: tuple[str, ...]) -> None:
    """Add the observer and the markers to an access list."""
    for name, keys in (("all", ["**", "**/@adv/**", "@/*/@ros2_lv/**", "@ros2_lv/**"]), ("markers", [MARKERS])):
        rule = {"id": name, "permission": "allow", "messages": MESSAGES, "key_exprs": keys}
        access["rules"].append(rule | {"flows": ["ingress", "egress"]})
    for policy in access["policies"]:
        policy["rules"].append("markers")
    access["subjects"].append({"id": OBSERVER} | {by: [OBSERVER] for by in proved_by})
    access["policies"].append({"subjects": [OBSERVER], "rules": ["all"]})


def script(name: str) -> Any:
    """Import a module of deploy/zenoh, which is no package."""
    if str(FOLDER) not in sys.path:
        sys.path.insert(0, str(FOLDER))
    return importlib.import_module(name)


@dataclass(frozen=True)
class LabRouter:
    """Running router of a lab.

    Attributes:
        process: of the router.
        login: `certificates`, `passwords` or `both`.
        folder: of certificates and passwords.
        passwords: of each client.
    """

    process: Router
    login: str
    folder: Path
    passwords: dict[str, str]

    def entries(self, user: str | None, certificate: str | None, password: str | None = None) -> dict[str, Any]:
        """Build the entries of a client's configuration, by path.

        Args:
            user: user name; None: none.
            certificate: name of the certificate's file, without `.pem`; None: none.
            password: of the user; None: the right one.
        """
        given = password or self.passwords.get(user or "", "")
        entries = session_config([self.process.endpoint], user, given)
        tls: dict[str, Any] = {"root_ca_certificate": str(self.folder / "ca.pem")}
        if certificate is not None:
            tls["enable_mtls"] = True
            tls["connect_certificate"] = str(self.folder / f"{certificate}.pem")
            tls["connect_private_key"] = str(self.folder / f"{certificate}.key")
        return entries | {"transport/link/tls": tls}

    def entries_of(self, name: str) -> dict[str, Any]:
        """Build the entries of a client's configuration with all that its login needs."""
        user = None if self.login == "certificates" else name
        return self.entries(user, None if self.login == "passwords" else name)

    @contextmanager
    def joined(self, name: str) -> Iterator[zenoh.Session]:
        """Open a session as a client of the list."""
        with opened(self.entries_of(name)) as session:
            yield session


@contextmanager
def opened(entries: dict[str, Any]) -> Iterator[zenoh.Session]:
    """Open a session; raises zenoh.ZError where the router refuses it."""
    config = zenoh.Config()
    for path, value in entries.items():
        config.insert_json5(path, json.dumps(value))
    with zenoh.open(config) as session:
        yield session


def noting(seen: list[str], *, payloads: bool = False) -> "Callback[zenoh.Sample]":
    """Make the receiver of a subscription that adds the key of each sample to a list, or its payload."""

    def note(sample: zenoh.Sample) -> None:
        seen.append(sample.payload.to_string() if payloads else str(sample.key_expr))

    return Callback(note, indirect=False)


@contextmanager
def lab_router(folder: Path, login: str) -> Iterator[LabRouter]:
    """Run the router of a lab whose clients log in by certificates, passwords or both."""
    authority, stranger = Authority(folder), Authority(folder / "elsewhere")
    for name in ("router", "guest", OBSERVER, *NAMES):
        authority.issue(name)
    stranger.issue("tb3_1")
    make_access = script("make_access")
    lab = script("lab_list").read(LAB.format(login=login, folder=folder))
    listed = make_access.passwords(lab, f"guest:guest\n{OBSERVER}:all\n")
    (folder / "passwords").write_text(listed)
    written = make_access.configuration(lab)
    more = {path: written[path] for path in ("transport", "access_control")}
    admit_observer(more["access_control"], script("make_access").SUBJECTS[login])
    with router(more, "tls") as process:
        yield LabRouter(process, login, folder, dict(line.split(":") for line in listed.splitlines()))
