"""Names under which a console may be opened."""

import pytest

from voa_console.settings import ConsoleSettings, names_of


@pytest.mark.parametrize(
    ("host", "hosts", "names"),
    [
        ("127.0.0.1", (), ["localhost", "127.0.0.1", "[::1]"]),
        ("::1", ("lab",), ["localhost", "127.0.0.1", "[::1]", "lab"]),
        ("0.0.0.0", (), ["*"]),  # noqa: S104 - a name, not listened on
        ("192.168.0.7", ("lab",), ["localhost", "127.0.0.1", "[::1]", "lab"]),
    ],
)
def test_loopback_is_opened_by_its_names_alone(host: str, hosts: tuple[str, ...], names: list[str]) -> None:
    assert ConsoleSettings(host=host, hosts=hosts).names == names


def test_names_are_split_at_commas() -> None:
    assert names_of(" Lab.example, 10.0.0.7,,") == ("lab.example", "10.0.0.7")
