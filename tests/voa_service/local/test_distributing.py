"""Choice of where the parts of a ranking are computed."""

from pathlib import Path

import pytest

from tests.voa_service.local.documents import data_document, local, nothing
from voa_service.failures import InvalidRequest
from voa_service.local import distributing as module
from voa_service.local.distributing import distribution
from voa_service.local.document import read_document
from voa_service.local.ranking import LocalRanking, ranked


def ranking(cluster: str | None, resume: Path | None, reports: list[tuple[int, int]]) -> LocalRanking:
    """Rank two places under a belief, and note the reports."""
    document = read_document(data_document({"belief": [0.2, 0.3, 0.5], "lookahead": 1}))

    def report(done: int, total: int) -> None:
        reports.append((done, total))

    with local() as built, distribution(cluster, resume, report) as distribute:
        return ranked(built, document, distribute, nothing)


def test_results_are_kept_in_the_folder_and_read_from_it(tmp_path: Path) -> None:
    reports: list[tuple[int, int]] = []
    first = ranking(None, tmp_path, reports)
    written = {file: file.stat().st_mtime_ns for file in tmp_path.rglob("*.pickle")}
    assert len(written) == 2
    assert ranking(None, tmp_path, reports) == first == ranking(None, None, reports)
    assert {file: file.stat().st_mtime_ns for file in tmp_path.rglob("*.pickle")} == written
    assert reports == 3 * [(1, 2), (2, 2)]


def test_without_dask_it_says_what_to_install(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(module, "find_spec", lambda name: None)
    with pytest.raises(InvalidRequest, match="install the extra `cluster`"):
        ranking("local", None, [])
