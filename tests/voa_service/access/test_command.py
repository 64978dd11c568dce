"""`voa keys`: makes keys, lists them, and revokes them, in the database of a service."""

import json
from datetime import UTC, datetime, timedelta
from pathlib import Path

import pytest

from tests.support.api_keys import make_key, url_of
from tests.support.serving import serving
from tests.support.waiting import wait_for
from voa_service.access.command import main
from voa_service.access.keys import id_of

Captured = pytest.CaptureFixture[str]


@pytest.fixture
def url(database_url: str, monkeypatch: pytest.MonkeyPatch) -> str:
    """A database that the environment names."""
    monkeypatch.setenv("VOA_DATABASE_URL", database_url)
    return database_url


def keys(capsys: Captured, *options: str) -> list[dict[str, object]]:
    capsys.readouterr()
    assert main(["list", "--json", *options]) == 0
    return list(json.loads(capsys.readouterr().out))


def test_a_key_is_printed_once_alone_on_its_line(url: str, capsys: Captured) -> None:
    assert main(["create", "tb3_1", "--role", "sensor", "--robot", "tb3_1", "--expires-in", "90d"]) == 0
    printed = capsys.readouterr()
    text = printed.out.removesuffix("\n")
    assert id_of(text) is not None
    assert "closes the service" in printed.err
    assert text not in printed.err
    assert main(["create", "tb3_1", "--role", "sensor", "--session", "a", "--session", "b"]) == 0
    assert "closes" not in capsys.readouterr().err
    one, two = keys(capsys)
    assert (one["id"], one["name"], one["role"], one["robots"]) == (id_of(text), "tb3_1", "sensor", ["tb3_1"])
    assert (two["sessions"], two["robots"], two["expires_at"], two["state"]) == (["a", "b"], None, None, "active")
    left = datetime.fromisoformat(str(one["expires_at"])) - datetime.now(UTC)
    assert timedelta(days=89, hours=23) < left <= timedelta(days=90)
    assert main(["list"]) == 0
    assert text not in (shown := capsys.readouterr().out)
    assert str(id_of(text)) in shown


def test_keys_are_revoked_for_good(url: str, capsys: Captured) -> None:
    ids = [str(id_of(make_key(url, "viewer"))) for _ in range(2)]
    assert main(["revoke", f"voa_{ids[0]}"]) == 0
    captured = capsys.readouterr()
    assert f"revoked {ids[0]} (viewer-1, viewer)" in captured.out
    assert "refuses every caller" not in captured.err
    assert [key["id"] for key in keys(capsys)] == ids[1:]
    assert main(["revoke", *ids]) == 0
    captured = capsys.readouterr()
    assert "was revoked before" in captured.out
    assert "refuses every caller" in captured.err
    assert keys(capsys) == []
    assert {str(key["state"]) for key in keys(capsys, "--all")} == {"revoked"}
    assert main(["list"]) == 0
    assert "no key is valid" in capsys.readouterr().out


def test_nothing_is_revoked_where_an_id_is_unknown_or_is_the_key_itself(url: str, capsys: Captured) -> None:
    text = make_key(url, "viewer")
    assert main(["revoke", str(id_of(text)), "0123"]) == 1
    assert "there is no key '0123'; nothing was revoked" in capsys.readouterr().err
    assert main(["revoke", text]) == 1
    said = capsys.readouterr().err
    assert "expected the id of a key" in said
    assert text not in said
    assert len(keys(capsys)) == 1


def test_who_makes_and_revokes_keys_is_in_a_line_of_the_audit(
    url: str, capsys: Captured, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("getpass.getuser", lambda: "anna")
    assert main(["create", "tb3_1", "--role", "sensor", "--robot", "tb3_1"]) == 0
    made = capsys.readouterr()
    id_ = str(id_of(made.out.strip()))
    assert main(["revoke", id_]) == 0
    revoked = capsys.readouterr()
    assert main(["revoke", id_]) == 0
    again = capsys.readouterr()
    first, second = (json.loads(printed.err.splitlines()[0]) for printed in (made, revoked))
    shared: dict[str, object] = {
        "event": "audit",
        "level": "info",
        "caller": "anna",
        "key": id_,
        "name": "tb3_1",
        "role": "sensor",
    }
    shared |= {"sessions": None, "robots": ["tb3_1"], "result": 200}
    assert first == shared | {"call": "key.create", "timestamp": first["timestamp"]}
    assert second == shared | {"call": "key.revoke", "timestamp": second["timestamp"]}
    assert "audit" not in again.err, "it was revoked before"
    monkeypatch.setenv("VOA_LOG_LEVEL", "WARNING")
    assert main(["create", "tb3_1", "--role", "sensor"]) == 0
    assert "audit" not in capsys.readouterr().err


def test_keys_of_a_name_have_one_role(url: str, capsys: Captured) -> None:
    text = make_key(url, "sensor", "tb3_1")
    assert main(["create", "tb3_1", "--role", "operator"]) == 1
    assert "there is a key 'tb3_1' with the role sensor" in capsys.readouterr().err
    assert main(["create", "tb3_1", "--role", "sensor"]) == 0
    assert main(["revoke", str(id_of(text))]) == 0
    assert len(keys(capsys)) == 1


def test_a_file_gets_a_key_that_only_its_owner_reads(url: str, tmp_path: Path, capsys: Captured) -> None:
    file = tmp_path / "anna.key"
    assert main(["create", "anna", "--role", "operator", "-o", str(file)]) == 0
    assert capsys.readouterr().out == ""
    text = file.read_text().removesuffix("\n")
    assert id_of(text) == keys(capsys)[0]["id"]
    assert file.stat().st_mode & 0o777 == 0o600
    assert main(["create", "anna", "--role", "operator", "-o", str(file)]) == 1
    assert "expected a new file" in capsys.readouterr().err
    assert file.read_text() == f"{text}\n"
    assert len(keys(capsys)) == 1


@pytest.mark.parametrize("name", ["", "a b", "ü", "a" * 65, "a\n", "../a"])
def test_a_name_is_short_and_plain(tmp_path: Path, name: str, capsys: Captured) -> None:
    assert main(["create", name, "--role", "arm", "--database-url", url_of(tmp_path / "voa.db")]) == 1
    assert "expected a name" in capsys.readouterr().err


def test_a_database_without_keys_is_open(tmp_path: Path, capsys: Captured) -> None:
    assert main(["list", "--database-url", url_of(tmp_path / "voa.db")]) == 0
    assert "answers everybody who reaches it, unless it runs with VOA_REQUIRE_KEYS=1" in capsys.readouterr().out


def test_what_is_wrong_is_said_in_one_line(monkeypatch: pytest.MonkeyPatch, capsys: Captured) -> None:
    assert main(["list", "--database-url", "sqlite:////nowhere/voa.db"]) == 1
    assert "there is no folder /nowhere" in capsys.readouterr().err
    monkeypatch.setenv("VOA_PORT", "many")
    assert main(["list"]) == 2
    assert "port" in capsys.readouterr().err
    for wrong in (
        ["create", "a"],
        ["create", "a", "--role", "king"],
        ["create", "a", "--role", "arm", "--expires-in", "1y"],
    ):
        with pytest.raises(SystemExit) as ended:
            main(wrong)
        assert ended.value.code == 2


def test_it_works_while_the_service_runs(tmp_path: Path, capsys: Captured) -> None:
    with serving(tmp_path) as service:
        url = url_of(service.database)
        assert main(["create", "anna", "--role", "viewer", "--database-url", url]) == 0
        text = capsys.readouterr().out.splitlines()[-1]  # after the log of the service
        wait_for(lambda: service.http.get("/v1/lidars").status_code == 401, "the first key")
        header = {"Authorization": f"Bearer {text}"}
        assert service.http.get("/v1/lidars", headers=header).status_code == 200
        assert main(["revoke", str(id_of(text)), "--database-url", url]) == 0
        wait_for(lambda: service.http.get("/v1/lidars", headers=header).status_code == 401, "the revocation")
