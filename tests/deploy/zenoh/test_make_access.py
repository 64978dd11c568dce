"""Lists of a lab: what is read from them, what is refused, and the configuration that the script writes."""

import json
from pathlib import Path
from typing import Any

import pytest
import zenoh
from hypothesis import given
from hypothesis import strategies as st

from tests.support.lab_router import FOLDER, script
from tests.support.serving import Service
from voa_ros.robot_outputs import Inputs, Outputs
from voa_service.rpc.methods import methods_of

SMALL = """
[files]
ca = "ca.pem"
certificate = "router.pem"
key = "router.key"
passwords = "passwords"
[service]
name = "voa"
"""
access: Any = script("make_access")
lists: Any = script("lab_list")


def rules_of(configuration: dict[str, Any], name: str) -> list[dict[str, Any]]:
    """Find the rules of a client."""
    control = configuration["access_control"]
    (policy,) = [policy for policy in control["policies"] if policy["subjects"] == [name]]
    return [rule for rule in control["rules"] if rule["id"] in policy["rules"]]


def test_the_shipped_list_becomes_a_configuration_that_zenoh_reads(tmp_path: Path) -> None:
    out = tmp_path / "router.json5"
    assert access.main([str(FOLDER / "lab.toml"), "-o", str(out)]) == 0
    read = zenoh.Config.from_file(out)
    assert json.loads(read.get_json("access_control/default_permission")) == "deny"
    assert json.loads(read.get_json("access_control/enabled")) is True
    assert json.loads(read.get_json("transport/link/tls/enable_mtls")) is True
    assert json.loads(read.get_json("listen/endpoints")) == ["tls/[::]:7447"]
    assert json.loads(read.get_json("adminspace/enabled")) is False


@pytest.mark.parametrize(
    ("login", "subject"),
    [
        ("certificates", {"cert_common_names": ["voa"]}),
        ("passwords", {"usernames": ["voa"]}),
        ("both", {"cert_common_names": ["voa"], "usernames": ["voa"]}),
    ],
)
def test_a_subject_has_all_that_its_login_proves(login: str, subject: dict[str, Any]) -> None:
    written = access.configuration(lists.read(f'login = "{login}"\n{SMALL}'))
    assert written["access_control"]["subjects"] == [{"id": "voa"} | subject]
    assert ("auth" in written["transport"]) is (login != "certificates")
    assert written["transport"]["link"]["tls"].get("enable_mtls", False) is (login != "passwords")


def test_every_rule_belongs_to_one_client_and_names_keys() -> None:
    written = access.configuration(lists.read((FOLDER / "lab.toml").read_text()))["access_control"]
    used = [rule for policy in written["policies"] for rule in policy["rules"]]
    assert sorted(used) == sorted(rule["id"] for rule in written["rules"])
    assert all(rule["key_exprs"] and rule["messages"] and rule["flows"] for rule in written["rules"])
    assert not any(key in ("**", "*") for rule in written["rules"] for key in rule["key_exprs"])


@pytest.mark.parametrize(
    ("text", "says"),
    [
        ("", r"expected a section \[service\]"),
        ("[service", "at the end of a table declaration"),
        (f"colour = 1\n{SMALL}", "the list has no 'colour'"),
        (f'login = "none"\n{SMALL}', "login: expected one of certificates, passwords, both"),
        ('service = "voa"', "service: expected a section, got 'voa'"),
        (f'root = "voa/**"\n{SMALL}', "root: expected parts of letters"),
        (f'listen = ["tcp/[::]:7447"]\n{SMALL}', "login by certificates needs TLS"),
        (f"listen = 7447\n{SMALL}", "listen: expected a list, got 7447"),
        (f'robot = ["r"]\n{SMALL}', r"expected sections \[\[robot\]\], got 'r'"),
        (f'{SMALL}\n[[arm]]\nname = "r"\npublishes = "scan"\n', "publishes: expected a list, got 'scan'"),
        (f'{SMALL}\n[[arm]]\nname = "r"\ndomain = "7"\n', "domain: expected a number, got '7'"),
        (SMALL.replace('"voa"', '"a/b"'), "name of a service"),
        (f"{SMALL}\n[[robot]]\n", "name of a robot"),
        (f'{SMALL}\n[[robot]]\nname = "voa"\n', "'voa' stands there twice"),
        (f'{SMALL}\n[[robot]]\nname = "r"\ncolour = 1\n', r"\[\[robot\]\] has no 'colour'"),
        (f'{SMALL}\n[[viewer]]\nname = "r"\nscans = "all"\n', "scans: expected true or false, got 'all'"),
        (f'{SMALL}\n[[robot]]\nname = "r"\nscans = true\n', r"\[\[robot\]\] has no 'scans'"),
        (f'{SMALL}\n[[arm]]\nname = "r"\nnamespace = "x"\n', r"\[\[arm\]\] has no 'namespace'"),
        (f'{SMALL}\n[[robot]]\nname = "r"\npublishes = ["a b"]\n', "expected a topic such as"),
        (f'{SMALL}\n[[robot]]\nname = "r"\npublishes = ["**"]\n', "expected a topic such as"),
        (f'{SMALL}\n[[robot]]\nname = "r"\nnamespace = "voa"\n', "would open keys of the service"),
        (f'{SMALL}\n[[viewer]]\nname = "r"\nreceives = ["*/**"]\n', "would open keys of the service"),
        (f'{SMALL}\n[[robot]]\nname = "a"\n[[robot]]\nname = "b"\npublishes = ["a/scan"]\n', "would both publish"),
    ],
)
def test_a_list_with_a_mistake_is_refused(text: str, says: str) -> None:
    with pytest.raises(lists.InvalidList, match=says):
        lists.read(text)


def test_a_mistake_is_one_line(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    listed = tmp_path / "lab.toml"
    listed.write_text(SMALL.replace('certificate = "router.pem"', ""))
    assert access.main([str(listed)]) == 2
    (line,) = capsys.readouterr().err.splitlines()
    assert line == f"make_access.py: {listed}: login by certificates: expected 'certificate' in the section [files]"


def test_passwords_are_made_once_and_kept_from_others(tmp_path: Path) -> None:
    file = tmp_path / "passwords"
    listed = tmp_path / "lab.toml"
    listed.write_text(f'login = "both"\n{SMALL}')
    file.write_text("someone:secret\n")
    for _ in range(2):
        assert access.main([str(listed), "-o", str(tmp_path / "out"), "--passwords", str(file)]) == 0
    lines = file.read_text().splitlines()
    assert [line.split(":")[0] for line in lines] == ["someone", "voa"]
    assert len(lines[1].split(":")[1]) >= 32
    assert file.stat().st_mode & 0o077 == 0


def test_a_robot_without_a_namespace_publishes_its_topics_alone() -> None:
    written = access.configuration(
        lists.read(f'{SMALL}\n[[robot]]\nname = "r"\nnamespace = ""\npublishes = ["/scan"]\ndomain = 3\n')
    )
    puts = [rule["key_exprs"] for rule in rules_of(written, "r") if "put" in rule["messages"]]
    assert ["scan", "3/scan/*/*"] in puts


def test_the_keys_beside_scans_reach_the_service_and_who_is_trusted_with_them_alone() -> None:
    """A subscriber to scans reads the API keys in their attachments."""
    lab = lists.read((FOLDER / "lab.toml").read_text() + '\n[[viewer]]\nname = "trusted"\nscans = true\n')
    written, scans = access.configuration(lab), f"{lab.root}/scan/*/*"
    receiving = {
        client.name
        for client in lab.clients
        for rule in rules_of(written, client.name)
        if ("egress" in rule["flows"] and "put" in rule["messages"])
        or ("ingress" in rule["flows"] and "declare_subscriber" in rule["messages"])
        if any(lists.intersect(key, scans) for key in rule["key_exprs"])
    }
    assert receiving == {"voa-service", "trusted"}


def test_the_usual_outputs_come_from_the_service_alone_and_the_inputs_do_not() -> None:
    switches = dict.fromkeys(("belief", "poses", "markers", "grasps", "best_grasp", "place", "numbers"), True)
    outputs = [topic.removeprefix("voa/") for topic in Outputs.model_validate(switches).topics]
    inputs = [topic.removeprefix("voa/") for topic in Inputs.model_validate({"prior": True, "outcome": True}).topics]
    kept = [zenoh.KeyExpr(topic) for topic in lists.OUTPUTS]
    assert all(any(each.includes(zenoh.KeyExpr(topic)) for each in kept) for topic in outputs)
    assert not any(each.intersects(zenoh.KeyExpr(topic)) for each in kept for topic in inputs)
    assert all(any(each.includes(zenoh.KeyExpr(topic)) for topic in outputs) for each in kept)


def test_the_methods_that_viewers_may_call_exist_and_change_nothing(service: Service) -> None:
    methods = {name: zenoh.KeyExpr(f"rpc/{name}") for name in methods_of(service.inside)}
    allowed = {pattern: zenoh.KeyExpr(f"rpc/{pattern}") for pattern in access.READING}
    readable = {name for name, key in methods.items() if any(each.includes(key) for each in allowed.values())}
    assert all(any(each.includes(key) for key in methods.values()) for each in allowed.values())
    changing = {
        "object.create", "scenario.create", "session.create", "session.delete", "look.announce", "look.cancel",
        "belief.put", "scan.apply", "outcome.report", "robot.look", "object.delete", "scenario.delete",
    }  # fmt: skip
    assert changing == set(methods) - readable


chunks = st.sampled_from(["a", "b", "*"])
expressions = st.tuples(st.lists(chunks, min_size=1, max_size=4), st.sampled_from(["", "/**"])).map(
    lambda parts: "/".join(parts[0]) + parts[1]
)


@given(expressions, expressions)
def test_key_expressions_intersect_as_zenoh_says(one: str, other: str) -> None:
    assert lists.intersect(one, other) is zenoh.KeyExpr(one).intersects(zenoh.KeyExpr(other))
