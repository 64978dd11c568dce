"""`voa restore` puts a backup in the place of a database, and never under a service that runs."""

from pathlib import Path

import pytest

from tests.support.api_keys import make_key, revoke_key, url_of
from tests.support.replicas import replicas
from tests.voa_service.test_backup import opened
from voa_client import Client, NotFoundError
from voa_service import backup
from voa_service.restore import main
from voa_store.starting import open_keys


def test_a_database_goes_back_to_its_backup(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    url, file = f"sqlite:///{tmp_path / 'voa.db'}", str(tmp_path / "backup.db")
    with replicas(url, tmp_path) as (replica,), Client(replica.url) as client:
        first = opened(client)
        assert backup.main([file, "--database-url", url]) == 0
        second = opened(client)
        assert main([file, "--database-url", url]) == 1
        assert "voa.db is in use" in capsys.readouterr().err
        assert client.get_session(second).version == 0
    assert main([file, "--database-url", url]) == 0
    assert capsys.readouterr().out == (
        f"{tmp_path}/voa.db: restored, 1 sessions with 1 versions, all undamaged; the database from before is "
        f"{tmp_path}/voa.db.before-restore-1\n"
    )
    with replicas(url, tmp_path) as (replica,), Client(replica.url) as client:
        assert client.get_session(first).version == 0
        with pytest.raises(NotFoundError):
            client.get_session(second)


def test_a_file_that_is_no_backup_changes_nothing(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (tmp_path / "text.db").write_text("not a database " * 100)
    assert main([str(tmp_path / "text.db"), "--database-url", f"sqlite:///{tmp_path / 'voa.db'}"]) == 1
    assert "text.db cannot be copied" in capsys.readouterr().err
    assert not (tmp_path / "voa.db").exists()


@pytest.mark.parametrize(
    ("before", "line"),
    [
        (
            "keys",
            "keys: 0 carried over from the database before, 1 of the backup revoked as there; 0 of 1 keys are not",
        ),
        ("none", "keys: those of the backup, for there was no database before; 1 of 1 keys are not revoked: see `voa"),
        ("damaged", "keys: those of the database from before cannot be read; 1 of 1 keys are not revoked: see `voa"),
    ],
)
def test_the_keys_that_are_valid_afterwards_are_named(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], before: str, line: str
) -> None:
    database, file = tmp_path / "voa.db", str(tmp_path / "backup.db")
    key = make_key(url_of(database), "operator")
    assert backup.main([file, "--database-url", url_of(database)]) == 0
    if before == "keys":
        revoke_key(url_of(database), key)
    elif before == "none":
        database.unlink()
    else:
        database.write_bytes(b"no database at all" * 100)
    capsys.readouterr()
    assert main([file, "--database-url", url_of(database)]) == 0
    assert line in capsys.readouterr().out.splitlines()[1]


def test_a_backup_without_keys_in_the_place_of_an_unreadable_database_is_a_warning(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    database, file = tmp_path / "voa.db", str(tmp_path / "backup.db")
    open_keys(url_of(database)).close()
    assert backup.main([file, "--database-url", url_of(database)]) == 0
    database.write_bytes(b"no database at all" * 100)
    assert main([file, "--database-url", url_of(database)]) == 0
    assert "the backup has none: start the service with VOA_REQUIRE_KEYS=1" in capsys.readouterr().out
