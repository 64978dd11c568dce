"""The choice of an SQLite library, and the refusal of one that can lose commits."""

import sqlite3
import subprocess
import sys
from pathlib import Path

import pytest
from sqlalchemy import make_url

from voa_store import drivers
from voa_store.drivers import alone, database_file, loses_commits, sqlite_driver, version_of
from voa_store.errors import CannotOpen, FileInUse
from voa_store.sql import SqlStore
from voa_store.starting import open_store

OLD = (3, 40, 1)
HOLD = """
import sys
from pathlib import Path
from voa_store.drivers import alone
with alone(Path(sys.argv[1]), (3, 40, 1)):
    print("held", flush=True)
    sys.stdin.read()
"""


@pytest.mark.parametrize(
    ("version", "affected"),
    [
        ((3, 6, 23), False),
        ((3, 7, 0), True),
        ((3, 40, 1), True),
        ((3, 44, 5), True),
        ((3, 44, 6), False),
        ((3, 45, 0), True),
        ((3, 50, 6), True),
        ((3, 50, 7), False),
        ((3, 51, 0), True),
        ((3, 51, 2), True),
        ((3, 51, 3), False),
        ((3, 53, 4), False),
        ((4, 0, 0), False),
    ],
)
def test_versions_with_the_fault_are_known(version: tuple[int, ...], affected: bool) -> None:
    assert loses_commits(version) is affected


def test_the_driver_that_is_installed_here_has_no_such_fault(tmp_path: Path) -> None:
    assert not loses_commits(version_of(sqlite_driver()))
    store = SqlStore(f"sqlite:///{tmp_path / 'voa.db'}")
    assert store.software == f"SQLite {sqlite_driver().sqlite_version}"
    store.close()
    assert drivers.main() == 0


@pytest.mark.parametrize(
    ("url", "file"),
    [
        ("sqlite:///voa.db", "voa.db"),
        ("sqlite:////data/voa.db", "/data/voa.db"),
        ("sqlite:///file:/data/voa.db?mode=ro&uri=true", "/data/voa.db"),
        ("sqlite://", None),
        ("sqlite:///:memory:", None),
    ],
)
def test_the_file_of_a_url(url: str, file: str | None) -> None:
    assert database_file(make_url(url)) == (None if file is None else Path(file))


def test_a_file_is_held_by_one_process_and_free_when_that_is_killed(tmp_path: Path) -> None:
    file = tmp_path / "voa.db"
    command = [sys.executable, "-c", HOLD, str(file)]
    with subprocess.Popen(command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True) as other:
        assert other.stdout is not None
        assert other.stdout.readline() == "held\n"
        with pytest.raises(FileInUse, match=r"open in another process, and SQLite 3\.40\.1 .*pip install pysqlite3"):
            alone(file, OLD).__enter__()
        other.kill()
    with alone(file, OLD):
        pass


def test_a_second_service_is_refused_on_an_sqlite_with_the_fault(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("voa_store.engines.version_of", lambda _driver: OLD)
    url = f"sqlite:///{tmp_path / 'voa.db'}"
    first = open_store(url)
    with pytest.raises(CannotOpen, match="open in another process") as refused:
        open_store(url)
    assert not refused.value.may_pass
    first.close()
    open_store(url).close()


def test_without_a_bundled_sqlite_pythons_own_is_taken(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("importlib.util.find_spec", lambda _name: None)
    assert sqlite_driver() is sqlite3
