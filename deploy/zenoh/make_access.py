"""Write the configuration of a Zenoh router that refuses everything that the list of a lab does not allow.

    python deploy/zenoh/make_access.py deploy/zenoh/lab.toml -o router.json5
    zenohd -c router.json5

The list (TOML; lab.toml is an example) names the service, robots, arms and viewers. Each name is the common name of a
certificate, a user name, or both, as `login` says. The script needs Python 3.11 alone, to run on the router's machine.

| who     | puts                                   | queries below rpc/ | subscribes to                           |
|---------|----------------------------------------|--------------------|-----------------------------------------|
| service | belief/*, refused/*/*, outputs for ROS | answers all        | scan/*/*, belief/*, topics of robots    |
| robot   | scan/*/<name>, topics of its namespace | all                | belief/*, refused/*/<name>, its outputs |
| arm     |                                        | all                | belief/*                                |
| viewer  |                                        | those that read    | belief/*, refused/*/*                   |

Robots send their API keys beside their scans, so the service alone receives scan/*/*, and a viewer with `scans = true`,
such as a recorder, which is trusted with the keys of all robots. `publishes` and `receives` in the list add ROS 2
topics to a row. Everyone listed may see the liveliness tokens of the replicas (replica/*), and the service alone may
have them. Refusals are silent: Zenoh has no message for them.
"""

import argparse
import json
import os
import secrets
import sys
from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import Any

from lab_list import Client, InvalidList, Lab, intersect, keys_of, read

Rules = list[dict[str, Any]]
SUBJECTS = {
    "certificates": ("cert_common_names",),
    "passwords": ("usernames",),
    "both": ("cert_common_names", "usernames"),
}
"""Ways to log in, and the properties of a subject that each one proves; a subject must have all of them."""
READING = (
    "$*.get",
    "$*.list",
    "$*.rank",
    "$*.compute",
    "$*.mesh",
    "$*.scan",
    "$*.health",
    "$*.predict",
    "$*.warnings",
    "$*.stable_poses",
)
"""Key expressions of the methods that change nothing, below `rpc/`; viewers may call them."""
ANNOUNCEMENTS = ("@/*/@ros2_lv/**", "@ros2_lv/**")
"""Liveliness tokens by which zenoh-bridge-ros2dds and rmw_zenoh announce topics."""
_TAKES = "declare_subscriber"
_GETS = "put delete"
_DEMAND = "declare_subscriber"
"""Passed on to publishers: a bridge, and a router of a robot's own, send nothing that nobody subscribes to."""
_WATCHES = "liveliness_query declare_liveliness_subscriber"
_HEADER = "// Written by deploy/zenoh/make_access.py from {file}: change the list, not this file.\n"


def configuration(lab: Lab) -> dict[str, Any]:
    """Build the configuration of the router."""
    transport: dict[str, Any] = {"shared_memory": {"enabled": False}}
    if any(each.startswith(("tls/", "quic/")) for each in lab.listen):
        transport["link"] = {"protocols": sorted({each.partition("/")[0] for each in lab.listen}), "tls": _tls(lab)}
    if lab.login != "certificates":
        # The router must have a user itself before it asks others for theirs; nobody can log in as it.
        own = {"user": "router", "password": secrets.token_urlsafe(24)}
        transport["auth"] = {"usrpwd": own | {"dictionary_file": _file(lab, "passwords")}}
    return {
        "mode": "router",
        "listen": {"endpoints": list(lab.listen)},
        "scouting": {"multicast": {"enabled": False}, "gossip": {"enabled": False}},
        "adminspace": {"enabled": False},
        "transport": transport,
        "access_control": access_control(lab),
    }


def _tls(lab: Lab) -> dict[str, Any]:
    files = {"listen_certificate": _file(lab, "certificate"), "listen_private_key": _file(lab, "key")}
    if lab.login == "passwords":
        return files
    return files | {"root_ca_certificate": _file(lab, "ca"), "enable_mtls": True, "close_link_on_expiration": True}


def _file(lab: Lab, name: str) -> str:
    if name not in lab.files:
        raise InvalidList(f"login by {lab.login}: expected {name!r} in the section [files]")
    return lab.files[name]


def access_control(lab: Lab) -> dict[str, Any]:
    """Build the access list: for each client its rules, and a subject that only this client is."""
    rules = {client.name: _rules(lab, client) for client in lab.clients}
    return {
        "enabled": True,
        "default_permission": "deny",
        "rules": [rule for each in rules.values() for rule in each],
        "subjects": [{"id": name} | {by: [name] for by in SUBJECTS[lab.login]} for name in rules],
        "policies": [{"subjects": [name], "rules": [rule["id"] for rule in each]} for name, each in rules.items()],
    }


def _rules(lab: Lab, client: Client) -> Rules:
    """Build the rules of a client; ingress is what the router takes from it, egress what the router passes on to it."""
    number = 0

    def allow(flow: str, messages: str, keys: Iterable[str], permission: str = "allow") -> Rules:
        nonlocal number
        keys, number = list(keys), number + 1
        rule = {
            "id": f"{client.name} {number}",
            "permission": permission,
            "flows": [flow],
            "messages": messages.split(),
        }
        return [rule | {"key_exprs": keys}] if keys else []

    def both(messages_in: str, messages_out: str, keys: Sequence[str]) -> Rules:
        return allow("ingress", messages_in, keys) + allow("egress", messages_out, keys)

    def below(*keys: str) -> list[str]:
        return [f"{lab.root}/{key}" for key in keys]

    robots = [each for each in lab.clients if each.kind == "robot"]
    published, received = keys_of(client.publishes, client.domain), keys_of(client.receives)
    rules: Rules = []
    if client.kind == "service":
        for robot in robots:
            received += keys_of(robot.publishes)
            published += keys_of(robot.outputs, robot.domain)
        rules += both(_TAKES, _GETS, below("scan/*/*", "belief/*"))
        rules += both("put delete", _DEMAND, below("belief/*", "refused/*/*"))
        rules += both("declare_queryable reply", "query", below("rpc/*"))
        rules += both(f"liveliness_token {_WATCHES}", f"liveliness_token {_WATCHES}", below("replica/*"))
    else:
        methods = READING if client.kind == "viewer" else ("*",)
        watched = {"robot": ["belief/*", f"refused/*/{client.name}"], "arm": ["belief/*"]}
        watched["viewer"] = ["belief/*", "refused/*/*", *(["scan/*/*"] if client.scans else [])]
        rules += both("query", "reply", below(*(f"rpc/{method}" for method in methods)))
        rules += allow("egress", "declare_queryable", below("rpc/*"))
        rules += both(_TAKES, _GETS, below(*watched[client.kind]))
        rules += both(_WATCHES, "liveliness_token", below("replica/*"))
    if client.kind == "robot":
        received += keys_of(client.outputs)
        rules += allow("ingress", "put", keys_of(client.outputs, client.domain), "deny")
        rules += allow("ingress", "put", below(f"scan/*/{client.name}"))
        rules += allow("egress", _DEMAND, below("scan/*/*"))
    # Publishers of latched topics keep their newest samples, answer queries for them and announce that by a token.
    wanted = _wanted(lab, published)
    rules += allow("ingress", "put reply", published) + allow("egress", _DEMAND, wanted)
    rules += allow("ingress", "declare_queryable liveliness_token", _kept(published))
    rules += allow("egress", f"query {_WATCHES}", _kept(wanted))
    rules += both(_TAKES, f"{_GETS} reply", received)
    rules += both(f"query {_WATCHES}", "declare_queryable liveliness_token", _kept(received))
    # What robots announce of their ROS 2 topics, which `voa doctor` and `voa record` read.
    if client.kind == "robot":
        rules += both("liveliness_token", _WATCHES, ANNOUNCEMENTS)
    elif client.receives or client.kind == "service":
        rules += both(_WATCHES, "liveliness_token", ANNOUNCEMENTS)
    return rules


def _wanted(lab: Lab, published: Sequence[str]) -> list[str]:
    """List the keys of topics of a publisher, and all that clients receive and that may include some of them.

    A declaration is passed on only where its whole key expression is allowed: a subscription to `*/scan` would not
    reach a robot for which only subscriptions below `tb3_1/**` are passed on.
    """
    received = [key for client in lab.clients for key in keys_of(client.receives)]
    return [*published, *(key for key in received if any(intersect(key, each) for each in published))]


def _kept(keys: Iterable[str]) -> list[str]:
    """List the keys on which advanced publishers answer for the samples that they keep."""
    return [f"{key}/@adv/**" for key in keys]


def passwords(lab: Lab, existing: str) -> str:
    """Add a random password for each client that has none to the text of a file with `name:password` in each line."""
    known = {line.partition(":")[0] for line in existing.splitlines()}
    new = [f"{each.name}:{secrets.token_urlsafe(24)}" for each in lab.clients if each.name not in known]
    return "".join(f"{line}\n" for line in [*existing.splitlines(), *new])


def _add_passwords(file: Path, lab: Lab) -> None:
    """Complete the file of passwords, which only its owner may read."""
    existing = file.read_text(encoding="utf-8") if file.exists() else ""
    with open(os.open(file, os.O_WRONLY | os.O_CREAT | os.O_TRUNC, 0o600), "w", encoding="utf-8") as out:
        os.fchmod(out.fileno(), 0o600)
        out.write(passwords(lab, existing))


def main(arguments: Sequence[str] | None = None) -> int:
    """Write the configuration; return 0, or 2 where the list is not valid."""
    parser = argparse.ArgumentParser(prog="make_access.py", description=(__doc__ or "").partition("\n")[0])
    parser.add_argument("list", type=Path, metavar="LIST", help="list of the lab (TOML)")
    parser.add_argument("-o", "--out", type=Path, metavar="FILE", help="configuration of the router (default: stdout)")
    parser.add_argument(
        "--passwords", type=Path, metavar="FILE", help="add a random password for each name that this file has not"
    )
    options = parser.parse_args(arguments)
    try:
        lab = read(options.list.read_text(encoding="utf-8"))
        written = _HEADER.format(file=options.list.name) + json.dumps(configuration(lab), indent=2) + "\n"
        if options.passwords is not None:
            _add_passwords(options.passwords, lab)
        if options.out is None:
            sys.stdout.write(written)
        else:
            options.out.write_text(written, encoding="utf-8")
    except (OSError, UnicodeDecodeError, InvalidList) as error:
        print(f"make_access.py: {options.list}: {error}", file=sys.stderr)
        return 2
    return 0


if __name__ == "__main__":
    raise SystemExit(main())
