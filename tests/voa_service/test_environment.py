"""A slip in the name of a variable is noticed, and nothing that somebody reads is called unknown."""

import re
from pathlib import Path

import pytest

from voa_service.environment import known_variables, unknown_variables

REPOSITORY = Path(__file__).resolve().parents[2]


@pytest.mark.parametrize(
    ("name", "closest"),
    [
        ("VOA_LIMITS__BEAM", "VOA_LIMITS__BEAMS"),
        ("VOA_LIMITS_BEAMS", "VOA_LIMITS__BEAMS"),
        ("VOA_DATABASE", "VOA_DATABASE_URL"),
        ("VOA_ZENOH__CONECT", "VOA_ZENOH__CONNECT"),
        ("voa_prot", "VOA_PORT"),
        ("VOA_XYZZY", None),
    ],
)
def test_a_misspelt_variable_is_reported_with_the_closest_name(name: str, closest: str | None) -> None:
    assert unknown_variables([name, "PATH", "HOME"]) == {name: closest}


@pytest.mark.parametrize(
    "name",
    [
        "VOA_PORT",
        "voa_port",
        "VOA_LIMITS",
        "VOA_LIMITS__BEAMS",
        "VOA_CONNECTIONS__MOST",
        "VOA_SCREENSHOTS",
        "VOA_TEST_SCALE",
        "VOA_SERVICE_HOST",
        "VOA_SERVICE_PORT_HTTP",
        "VOA_PORT_8000_TCP_ADDR",
        "VOATING",
    ],
)
def test_what_somebody_reads_or_sets_is_known(name: str) -> None:
    assert unknown_variables([name]) == {}


def test_every_variable_that_the_clients_and_tests_read_is_known() -> None:
    files = [path for folder in ("clients", "tests", "assets") for path in (REPOSITORY / folder).rglob("*.py")]
    read = {
        name
        for path in files
        if path.resolve() != Path(__file__).resolve()
        for name in re.findall(r"""environ(?:\.get)?[\[(]\s*["'](VOA_\w+)""", path.read_text(encoding="utf-8"))
    }
    assert read
    assert read <= set(known_variables())
