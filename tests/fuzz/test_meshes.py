"""Damaged mesh files are read as a second reader reads them, or refused; `tests.fuzz.meshes` has the long run."""

import random

import pytest

from tests.fuzz.meshes import damaged, outcome, run
from tests.fuzz.seeds import SEEDS
from tests.support.scale import scaled
from voa_service.failures import Failure
from voa_service.meshes.reader import SubprocessMeshReader

COUNT = scaled(small=500, full=10_000)
THROUGH_THE_PROCESS = scaled(small=4, full=50)


@pytest.mark.parametrize("kind", SEEDS)
def test_whole_files_are_read_as_a_second_reader_reads_them(kind: str) -> None:
    for seed in SEEDS[kind]:
        assert outcome(kind, seed).startswith("read")


@pytest.mark.parametrize("kind", SEEDS)
def test_damaged_files_are_read_as_a_second_reader_reads_them_or_refused(kind: str) -> None:
    seen = run(kind, COUNT, seed=0)
    assert sum(seen.values()) == COUNT
    assert seen["refused with a reason"] > 0
    assert seen["read, as trimesh"] > 0


@pytest.mark.parametrize("kind", SEEDS)
def test_a_damaged_file_is_an_object_or_a_failure_with_one_line(kind: str) -> None:
    read = SubprocessMeshReader(seconds=30, mebibytes=1024, faces=1000)
    rng = random.Random(f"process {kind}")  # noqa: S311 - not a secret
    for _ in range(THROUGH_THE_PROCESS):
        content = damaged(kind, rng) or b" "
        failure = _failure(read, content, kind)
        if failure is not None:
            assert failure.kind == "invalid-mesh"
            assert "\n" not in failure.detail
            assert "Traceback" not in failure.detail
            assert "Error" not in failure.detail


def _failure(read: SubprocessMeshReader, content: bytes, kind: str) -> Failure | None:
    """Why a file is refused; None if it is an object."""
    try:
        assert len(read(content, kind, 1.0, "+Z").faces) > 0
    except Failure as failure:
        return failure
    return None
