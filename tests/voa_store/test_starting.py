"""Faults of a database at the start are one line that says what to do."""

from pathlib import Path

import psycopg
import pytest
from sqlalchemy import text

from tests.support.postgres import Server
from tests.voa_store.samples import engine_of
from voa_store.errors import CannotOpen
from voa_store.sql import SqlStore
from voa_store.starting import open_store


def refusal(url: str) -> CannotOpen:
    """Words of the failure to open a database, which must be one line."""
    with pytest.raises(CannotOpen) as refused:
        open_store(url, patience_s=2.0)
    assert "\n" not in str(refused.value)
    return refused.value


def test_a_folder_that_is_not_there(tmp_path: Path) -> None:
    error = refusal(f"sqlite:///{tmp_path}/nowhere/voa.db")
    assert str(error) == f"there is no folder {tmp_path}/nowhere: create it, or name another file with --database-url"
    assert not error.may_pass


def test_a_folder_instead_of_a_file(tmp_path: Path) -> None:
    assert f"sqlite:///{tmp_path}/voa.db" in str(refusal(f"sqlite:///{tmp_path}"))


def test_a_file_that_is_no_database(tmp_path: Path) -> None:
    file = tmp_path / "voa.db"
    file.write_text("beliefs, as text\n" * 1000)
    assert "is not an SQLite database" in str(refusal(f"sqlite:///{file}"))
    assert file.read_text().startswith("beliefs"), "it is left alone"


def test_a_file_that_cannot_be_written(tmp_path: Path) -> None:
    file = tmp_path / "voa.db"
    engine = engine_of(f"sqlite:///{file}")
    with engine.begin() as connection:
        connection.execute(text("CREATE TABLE other (x INTEGER)"))
    engine.dispose()
    assert "cannot be written by this user" in str(refusal(f"sqlite:///file:{file}?mode=ro&uri=true"))


def test_tables_of_a_newer_version(database_url: str) -> None:
    SqlStore(database_url).close()
    engine = engine_of(database_url)
    with engine.begin() as connection:
        connection.execute(text("UPDATE alembic_version SET version_num = '9999'"))
    engine.dispose()
    error = refusal(database_url)
    assert "written by a newer version of voa" in str(error)
    assert "9999" in str(error)
    assert not error.may_pass


@pytest.mark.parametrize("url", ["mysql://voa@127.0.0.1/voa", "voa.db", "sqlite:/voa.db", "nonsense://", ""])
def test_a_url_that_is_none(url: str) -> None:
    assert "expected sqlite:///FILE or postgresql://USER@HOST/DATABASE" in str(refusal(url))


def test_a_password_is_not_shown() -> None:
    assert "hunter2" not in str(refusal("postgresql://voa:hunter2@127.0.0.1:1/voa"))


def test_a_server_that_is_not_there_may_come() -> None:
    error = refusal("postgresql://voa@127.0.0.1:1/voa")
    assert "no server answers there: start PostgreSQL, or check host and port" in str(error)
    assert error.may_pass


def test_a_role_or_database_that_is_not_there_does_not_come(postgres: Server) -> None:
    url = postgres.new_database()
    for wrong, says in (
        (url.replace("voa@", "nobody@"), "there is no role 'nobody': create it with `createuser nobody`"),
        (url + "_gone", "there is no such database: create it with `createdb -O voa"),
    ):
        error = refusal(wrong)
        assert says in str(error)
        assert not error.may_pass


def test_a_role_that_may_not_create_tables(postgres: Server) -> None:
    url = postgres.new_database()
    with psycopg.connect(url, autocommit=True) as connection:
        connection.execute("CREATE ROLE reader LOGIN")
    error = refusal(url.replace("voa@", "reader@"))
    assert "GRANT CREATE, USAGE ON SCHEMA public TO reader" in str(error)
    assert not error.may_pass


def test_a_server_that_is_read_only(postgres: Server) -> None:
    error = refusal(postgres.new_database() + "?options=-c%20default_transaction_read_only%3Don")
    assert "is read-only, a standby perhaps: name the primary server" in str(error)


class Time:
    """A clock that moves when somebody waits; what `come` does happens after the second wait."""

    def __init__(self) -> None:
        self.now = 0.0
        self.pauses = 0

    def pause(self, seconds: float) -> None:
        self.now += seconds
        self.pauses += 1


def test_a_database_that_starts_after_the_service_is_awaited(postgres: Server) -> None:
    url, time = postgres.new_database(), Time()
    postgres.stop()

    def pause(seconds: float) -> None:
        time.pause(seconds)
        if time.pauses == 2:
            postgres.start()

    store = open_store(url, wait_s=60.0, pause=pause, clock=lambda: time.now)
    assert time.pauses == 2
    store.ping()
    store.close()


def test_one_that_never_comes_is_waited_for_no_longer_than_said() -> None:
    time = Time()
    with pytest.raises(CannotOpen, match="no server answers there"):
        open_store("postgresql://voa@127.0.0.1:1/voa", wait_s=2.2, pause=time.pause, clock=lambda: time.now)
    assert time.now == pytest.approx(2.2)


def test_what_time_does_not_mend_is_not_waited_for(tmp_path: Path) -> None:
    time = Time()
    with pytest.raises(CannotOpen, match="there is no folder"):
        open_store(f"sqlite:///{tmp_path}/no/voa.db", wait_s=60.0, pause=time.pause, clock=lambda: time.now)
    assert time.pauses == 0
