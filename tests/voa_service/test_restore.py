"""`voa restore` puts a backup in the place of a database, and never under a service that runs."""

from pathlib import Path

import pytest

from tests.support.replicas import replicas
from tests.voa_service.test_backup import opened
from voa_client import Client, NotFoundError
from voa_service import backup
from voa_service.restore import main


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
