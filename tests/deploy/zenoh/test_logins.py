"""Logins to the router: who is admitted at all; a client that is not in the list may do nothing there."""

from typing import Any

import pytest
import zenoh

from tests.support.lab_router import LabRouter, noting, opened
from tests.support.waiting import wait_for

SCAN = "voa/v1/lab7/scan/s1/tb3_1"


def is_admitted(entries: dict[str, Any]) -> bool:
    try:
        with opened(entries):
            return True
    except zenoh.ZError:
        return False


def test_a_client_of_the_list_logs_in(lab: LabRouter) -> None:
    assert is_admitted(lab.entries_of("tb3_1"))


@pytest.mark.parametrize(
    ("user", "certificate", "password", "logins"),
    [
        pytest.param("tb3_1", "tb3_1", "wrong", set(), id="wrong password"),
        pytest.param("nobody", "tb3_1", "x", set(), id="unknown user"),
        pytest.param(None, "tb3_1", None, {"certificates"}, id="no user"),
        pytest.param("router", "tb3_1", "x", set(), id="the user of the router itself"),
        pytest.param("tb3_1", None, None, {"passwords"}, id="no certificate"),
        pytest.param("tb3_1", "elsewhere/tb3_1", None, {"passwords"}, id="certificate of another authority"),
        pytest.param(None, None, None, set(), id="neither"),
    ],
)
def test_who_cannot_prove_a_name_does_not_log_in(
    lab: LabRouter, user: str | None, certificate: str | None, password: str | None, logins: set[str]
) -> None:
    assert is_admitted(lab.entries(user, certificate, password)) is (lab.login in logins)


def test_the_router_takes_no_connection_without_tls(lab: LabRouter) -> None:
    entries = lab.entries_of("tb3_1")
    entries["connect"] = entries["connect"] | {"endpoints": [lab.process.endpoint.replace("tls/", "tcp/")]}
    assert not is_admitted(entries)


def test_a_client_refuses_a_router_of_another_authority(lab: LabRouter) -> None:
    entries = lab.entries_of("tb3_1")
    entries["transport/link/tls"] |= {"root_ca_certificate": str(lab.folder / "elsewhere" / "ca.pem")}
    assert not is_admitted(entries)


def test_who_is_not_listed_logs_in_and_may_do_nothing(lab: LabRouter, observing: zenoh.Session) -> None:
    assert not _passes(lab, lab.entries_of("guest"), observing)
    assert _passes(lab, lab.entries_of("tb3_1"), observing)


def test_a_robot_with_the_certificate_or_the_password_of_another_is_not_that_one(
    lab: LabRouter, observing: zenoh.Session
) -> None:
    """A stolen certificate or password alone is not enough where both are needed."""
    wrong = {
        "certificates": [lab.entries(None, "tb3_2")],
        "passwords": [lab.entries("tb3_2", "tb3_1")],  # a certificate proves nothing there
        "both": [lab.entries("tb3_2", "tb3_1"), lab.entries("tb3_1", "tb3_2")],
    }
    for entries in wrong[lab.login]:
        assert not _passes(lab, entries, observing)


def _passes(lab: LabRouter, entries: dict[str, Any], observing: zenoh.Session) -> bool:
    """Put a scan of tb3_1 as a client, then one as tb3_1 itself; return True if both arrive."""
    seen: list[str] = []
    note = noting(seen, payloads=True)
    with observing.declare_subscriber(SCAN, note), opened(entries) as client, lab.joined("tb3_1") as robot:

        def arrived(text: str) -> bool:
            robot.put(SCAN, text)
            return text in seen

        wait_for(lambda: arrived("ready"), "the subscription", 10.0)
        client.put(SCAN, "of the client")
        # It returns when the router has dealt with all that the client sent before.
        list(client.liveliness().get("marker/*", timeout=5.0))
        wait_for(lambda: arrived("end"), "the marker", 10.0)
    return "of the client" in seen
