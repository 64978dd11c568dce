"""A write-ahead log that the disk has changed: commits that SQLite drops are noticed, and nothing else is."""

import errno
import json
import shutil
from pathlib import Path
from typing import Any, NamedTuple

import pytest

from tests.voa_store.samples import change, create, next_version, scenario, write
from voa_store import write_ahead
from voa_store.sql import SqlStore
from voa_store.verify import main

WRITES = 6
STEP = 4_001
"""Distance of the bytes of the log that are changed, one at a time."""


class Crashed(NamedTuple):
    """Files of a database as a crash leaves them, and the size of its log after each write."""

    folder: Path
    sizes: list[int]

    @property
    def log(self) -> bytes:
        return (self.folder / "voa.db-wal").read_bytes()

    def versions(self, log: bytes, folder: Path) -> tuple[int, bool]:
        """Open a copy with another log; return the versions that are there, and True if a loss was reported."""
        folder.mkdir()
        shutil.copyfile(self.folder / "voa.db", folder / "voa.db")
        (folder / "voa.db-wal").write_bytes(log)
        store = SqlStore(f"sqlite:///{folder / 'voa.db'}")
        state = store.get_session("S")
        store.close()
        reported = (folder / "voa.db-wal-damaged").is_file()
        if reported:
            assert (folder / "voa.db-wal-damaged").read_bytes() == log
        return (-1 if state is None else state.version), reported


@pytest.fixture
def crashed(tmp_path: Path) -> Crashed:
    """A database whose log has six commits that nobody has moved into the file."""
    own = tmp_path / "running"
    own.mkdir()
    store = SqlStore(f"sqlite:///{own / 'voa.db'}")
    store.put_scenario(scenario("A"))
    create(store)
    store.close()
    store = SqlStore(f"sqlite:///{own / 'voa.db'}")
    sizes = []
    for number in range(WRITES):
        change(store, "S", write(request=json.dumps(f"{number}" + "x" * 5_000)), next_version)
        sizes.append((own / "voa.db-wal").stat().st_size)
    shutil.copytree(own, tmp_path / "crashed")
    store.close()
    return Crashed(tmp_path / "crashed", sizes)


def with_flipped_bit(log: bytes, at: int, bit: int = 3) -> bytes:
    changed = bytearray(log)
    changed[at] ^= 1 << bit
    return bytes(changed)


def test_a_log_as_a_crash_leaves_it_is_read_whole(crashed: Crashed, tmp_path: Path) -> None:
    assert crashed.versions(crashed.log, tmp_path / "copy") == (WRITES, False)


@pytest.mark.parametrize("missing", [1, 2_000, 9_000])
def test_a_transaction_that_was_not_finished_is_no_loss(crashed: Crashed, tmp_path: Path, missing: int) -> None:
    assert crashed.versions(crashed.log[:-missing], tmp_path / "copy") == (WRITES - 1, False)


def test_a_changed_bit_before_synced_commits_is_reported_and_named(
    crashed: Crashed, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    damaged = with_flipped_bit(crashed.log, crashed.sizes[1] + 1_000)
    assert crashed.versions(damaged, tmp_path / "copy") == (2, True)
    capsys.readouterr()
    assert main([f"sqlite:///{tmp_path / 'copy' / 'voa.db'}"]) == 1
    (line,) = json.loads(capsys.readouterr().out)["pages"]
    assert "voa.db-wal-damaged" in line
    assert "restore a backup" in line


def test_a_changed_bit_anywhere_in_the_log_loses_at_most_its_newest_commit_unnoticed(
    crashed: Crashed, tmp_path: Path
) -> None:
    losses = {}
    for number, at in enumerate(range(12, len(crashed.log), STEP)):
        version, reported = crashed.versions(with_flipped_bit(crashed.log, at), tmp_path / str(number))
        losses[at] = (WRITES - version, reported)
    lost = {at: loss for at, loss in losses.items() if loss[0] > 1}
    assert len(lost) > 10
    assert [at for at, (_, reported) in lost.items() if not reported] == []
    assert not any(reported for missing, reported in losses.values() if missing == 0)


@pytest.mark.parametrize("at", [4, 17, 22, 28])
def test_a_changed_bit_in_the_header_of_the_log_is_reported(crashed: Crashed, tmp_path: Path, at: int) -> None:
    assert crashed.versions(with_flipped_bit(crashed.log, at), tmp_path / "copy") == (0, True)


def test_what_a_failed_commit_has_left_behind_is_no_loss(crashed: Crashed, tmp_path: Path) -> None:
    """Two commits that failed leave frames behind a shorter one, which does not continue in them."""
    first, second = crashed.sizes[2], crashed.sizes[3]
    left = crashed.log[crashed.sizes[3] : crashed.sizes[4]]
    log = crashed.log[:second] + with_flipped_bit(left, 200) + crashed.log[first : first + len(left)]
    assert crashed.versions(log, tmp_path / "copy") == (4, False)


@pytest.mark.parametrize(("again", "reported"), [(True, False), (False, True)])
def test_commits_that_another_process_makes_meanwhile_are_no_loss(
    crashed: Crashed, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, *, again: bool, reported: bool
) -> None:
    page = int.from_bytes(crashed.log[8:12])
    new = (crashed.sizes[-1] - crashed.sizes[1]) // (24 + page)
    read, calls = write_ahead._frames_read, []

    def read_before_the_last_commits(connection: Any) -> int:
        calls.append(connection)
        return read(connection) - (0 if again and len(calls) > 1 else new)

    monkeypatch.setattr(write_ahead, "_frames_read", read_before_the_last_commits)
    assert crashed.versions(crashed.log, tmp_path / "copy") == (WRITES, reported)


def test_a_damaged_log_that_cannot_be_copied_keeps_nobody_from_starting(
    crashed: Crashed, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    def full(_log: Path, copy: Path) -> None:
        copy.write_bytes(b"part")
        raise OSError(errno.ENOSPC, "No space left on device")

    damaged = with_flipped_bit(crashed.log, crashed.sizes[1] + 1_000)
    with monkeypatch.context() as patched:
        patched.setattr("voa_store.write_ahead.shutil.copyfile", full)
        folder = tmp_path / "copy"
        folder.mkdir()
        (folder / "voa.db").write_bytes((crashed.folder / "voa.db").read_bytes())
        (folder / "voa.db-wal").write_bytes(damaged)
        store = SqlStore(f"sqlite:///{folder / 'voa.db'}")
    state = store.get_session("S")
    store.close()
    assert state is not None
    assert not (folder / "voa.db-wal-damaged").exists()
    printed = "".join(capsys.readouterr())
    assert "the database has lost answered writes" in printed
    assert "No space left on device" in printed
