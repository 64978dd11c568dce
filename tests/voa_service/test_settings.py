"""Settings: values that cannot be, host names, loopback addresses, and secrets that no error shows."""

from typing import Any

import pytest
from pydantic import ValidationError

from voa_connections.settings import ConnectionSettings
from voa_service.settings import Limits, Settings, ZenohSettings


@pytest.mark.parametrize("host", ["127.0.0.1", "127.1.2.3", "::1", "localhost"])
def test_loopback_addresses_are_those_of_this_machine(host: str) -> None:
    assert Settings(host=host).is_loopback


@pytest.mark.parametrize("host", ["0.0.0.0", "192.168.0.7", "::", "voa.lab.example"])  # noqa: S104 - not opened
def test_other_addresses_are_not(host: str) -> None:
    assert not Settings(host=host).is_loopback


@pytest.mark.parametrize(
    ("settings", "names"),
    [
        ({}, frozenset()),
        ({"host": "192.168.0.7"}, None),
        ({"host": "192.168.0.7", "hosts": "Voa.Lab., 10.0.0.7 ,"}, frozenset({"voa.lab", "10.0.0.7"})),
        ({"hosts": ("voa.lab",)}, frozenset({"voa.lab"})),
    ],
)
def test_a_service_on_loopback_answers_to_stated_names_alone(
    settings: dict[str, Any], names: frozenset[str] | None
) -> None:
    assert Settings(**settings).names == names


def test_the_largest_body_must_fit_into_the_memory_for_bodies() -> None:
    megabyte = 2**20
    few = ConnectionSettings(in_flight_mebibytes=10)
    Settings(connections=few, limits=Limits(body_bytes=10 * megabyte, upload_bytes=megabyte))
    for limits in (Limits(body_bytes=10 * megabyte + 1, upload_bytes=1), Limits(body_bytes=1, upload_bytes=11_000_000)):
        with pytest.raises(ValidationError, match="in_flight_mebibytes of at least 11"):
            Settings(connections=few, limits=limits)


def test_a_process_that_drains_has_longer_to_stop() -> None:
    assert Settings(drain_seconds=8.9).drain_seconds == 8.9
    for drain_seconds in (9.0, 30.0):
        with pytest.raises(ValidationError, match="expected stop_seconds above that, got 9"):
            Settings(drain_seconds=drain_seconds)


@pytest.mark.parametrize(
    "wrong", [{"port": -1}, {"port": 70_000}, {"workers": 0}, {"precision": "float16"}, {"database_patience_s": 0.5}]
)
def test_a_setting_beyond_its_bounds_is_refused(wrong: dict[str, Any]) -> None:
    with pytest.raises(ValidationError):
        Settings(**wrong)


@pytest.mark.parametrize("endpoint", ["tcp/192.168.0.2:7447", "unixsock-stream//tmp/zenoh", "tls/[::1]:7447"])
def test_an_endpoint_is_a_protocol_and_an_address(endpoint: str) -> None:
    assert ZenohSettings(connect=[endpoint]).connect == [endpoint]


@pytest.mark.parametrize("endpoint", ["192.168.0.2:7447", "tcp/", "/192.168.0.2", "tcp://192.168.0.2", ""])
def test_another_endpoint_is_refused_with_an_example(endpoint: str) -> None:
    with pytest.raises(ValidationError, match="as in tcp/192"):
        ZenohSettings(connect=[endpoint])


def test_a_password_needs_a_user_and_is_shown_nowhere() -> None:
    with pytest.raises(ValidationError, match="a password needs a user") as refused:
        ZenohSettings.model_validate({"password": "a secret"})
    assert "a secret" not in str(refused.value)
    with_user = ZenohSettings.model_validate({"user": "lab", "password": "a secret"})
    assert "a secret" not in repr(with_user)


def test_a_root_that_is_no_key_is_refused() -> None:
    with pytest.raises(ValidationError, match="expected a root like"):
        ZenohSettings(root="voa/*")
