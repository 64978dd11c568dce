"""Disks that fail, fill up, tear pages and change bits under a running service: answered writes stay, or are named."""

import os
import resource
import signal
import subprocess
from collections.abc import Callable, Iterator
from contextlib import AbstractContextManager, contextmanager
from pathlib import Path
from typing import NamedTuple

import httpx2
import pytest

from tests.support.history_calls import TIMEOUT, Recorder, Sent, assert_not_ready, opened, padded_scan
from tests.support.history_store import check_stored
from tests.support.replicas import replicas
from tests.support.scale import scaled
from tests.support.storage_faults import How, On, faulty_disk

FAILURES = [
    (On.WRITE, How.EIO),
    (On.WRITE, How.FULL),
    (On.WRITE, How.SHORT),
    (On.SYNC, How.EIO),
    (On.READ, How.EIO),
    (On.READ, How.FULL),
    (On.TRUNCATE, How.EIO),
]


def test_calls_that_fail_are_answered_and_lose_nothing_once_the_disk_works_again(tmp_path: Path) -> None:
    file, recorder, number = tmp_path / "voa.db", Recorder(), 0
    url = f"sqlite:///{file}"
    with (
        faulty_disk(tmp_path, file) as disk,
        replicas(url, tmp_path, environment=disk.environment) as (replica,),
        httpx2.Client(base_url=replica.url, timeout=TIMEOUT) as http,
    ):
        (session,) = opened(recorder, replica.url, 1)
        for on, how in FAILURES:
            for skip, times in ((0, 1000), (1, 1), (3, 2)):
                number += 1
                sent = padded_scan(session, number)
                disk.fail(on, how, skip=skip, times=times)
                assert_answered_or_refused(recorder.response(http, sent))
                assert http.get("/livez").status_code == 200
                disk.mend()
                assert recorder.response(http, sent).status_code == 200
                assert recorder.version(http, session) == number
        for skip in (0, 5):
            number += 1
            sent = padded_scan(session, number)
            disk.fail(On.WRITE, How.TORN, skip=skip, times=1)
            while recorder.write(http, sent) is not None:
                number += 1
                sent = padded_scan(session, number)
            assert replica.wait() == -signal.SIGKILL
            disk.mend()
            replica.start()
            assert recorder.response(http, sent).status_code == 200
    assert check_stored(url, recorder.calls) == number


def assert_answered_or_refused(response: httpx2.Response) -> None:
    """Assert that a write succeeded, or failed with a problem that says what to do."""
    if response.status_code == 500:  # SQLite takes a page that cannot be read for a damaged one
        assert response.json()["type"] == "urn:voa:problem:damaged"
        assert "disk" in response.json()["detail"]
    elif response.status_code != 200:
        assert_not_ready(response)


# ----------------------------------------------------------------------------------------------------- disk full


class SmallDisk(NamedTuple):
    """Folder on a disk that becomes full."""

    what: str
    folder: Path
    fill: Callable[[int], None]
    """Make the disk full for a process."""
    free: Callable[[int], None]
    """Make room again for a process."""


@contextmanager
def small_disk(folder: Path) -> Iterator[SmallDisk]:
    """A tmpfs of a megabyte (root only) that is made larger."""
    place = folder / "disk"
    place.mkdir()
    subprocess.run(["mount", "-t", "tmpfs", "-o", "size=1m", "voa-test", place], check=True, capture_output=True)

    def free(_: int) -> None:
        subprocess.run(["mount", "-o", "remount,size=64m", place], check=True, capture_output=True)

    try:
        yield SmallDisk("a tmpfs of 1 MB", place, lambda _: None, free)
    finally:
        subprocess.run(["umount", "--lazy", place], check=True, capture_output=True)


@contextmanager
def limited_files(folder: Path) -> Iterator[SmallDisk]:
    """Files of the process cannot grow beyond a megabyte (RLIMIT_FSIZE), until they can."""
    place = folder / "disk"
    place.mkdir()

    def limit(pid: int, size: int) -> None:
        hard = resource.prlimit(pid, resource.RLIMIT_FSIZE)[1]
        resource.prlimit(pid, resource.RLIMIT_FSIZE, (size, hard))

    yield SmallDisk(
        "RLIMIT_FSIZE of 1 MB", place, lambda pid: limit(pid, 2**20), lambda pid: limit(pid, resource.RLIM_INFINITY)
    )


def can_mount(folder: Path = Path("/tmp")) -> bool:  # noqa: S108 - only a mount point, and only if root
    """True if this process may mount; in most containers even root may not."""
    if os.geteuid() != 0:
        return False
    place = folder / f"voa-mount-{os.getpid()}"
    place.mkdir()
    try:
        if subprocess.run(["mount", "-t", "tmpfs", "voa-test", place], check=False, capture_output=True).returncode:
            return False
        subprocess.run(["umount", place], check=True, capture_output=True)
        return True
    finally:
        place.rmdir()


DISKS = [small_disk, limited_files] if can_mount() else [limited_files]


@pytest.mark.parametrize("kind", DISKS[: scaled(1, 2)], ids=lambda kind: kind.__name__)
def test_a_full_disk_is_a_503_that_loses_nothing_and_passes(
    kind: Callable[[Path], AbstractContextManager[SmallDisk]], tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    recorder = Recorder()
    with kind(tmp_path) as disk:
        url = f"sqlite:///{disk.folder / 'voa.db'}"
        with replicas(url, tmp_path) as (replica,), httpx2.Client(base_url=replica.url, timeout=TIMEOUT) as http:
            (session,) = opened(recorder, replica.url, 1)
            disk.fill(replica.pid)
            answered = 0
            refused: Sent | None = None
            for number in range(200):
                sent = padded_scan(session, number)
                response = recorder.response(http, sent)
                if response.status_code != 200:
                    assert_not_ready(response)
                    refused = sent
                    break
                answered += 1
            assert refused is not None, "the disk was never full"
            for _ in range(5):  # it stays so, and what was answered can still be read
                assert_not_ready(recorder.response(http, refused))
                assert recorder.version(http, session) == answered
            assert http.get("/livez").status_code == 200
            disk.free(replica.pid)
            for sent in (refused, padded_scan(session, 1000)):
                assert recorder.response(http, sent).status_code == 200
            replica.kill()
            replica.start()
            assert check_stored(url, recorder.calls) == answered + 2
    with capsys.disabled():
        print(f"\n  disk full ({disk.what}): {answered} scans answered, then none, then again")
