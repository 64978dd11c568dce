"""What the client costs is measured, and stays small."""

import json

import pytest

from tests.benchmarks import footprint


def test_the_figures_are_of_this_install(capsys: pytest.CaptureFixture[str]) -> None:
    assert footprint.main(["--json"]) == 0
    told = json.loads(capsys.readouterr().out)
    assert {"voa_client", "voa_msgs"} <= told["own_bytes"].keys()
    assert {"httpx2", "pydantic", "pydantic-core"} <= told["needed_bytes"].keys()
    assert not {"numpy", "fastapi", "eclipse-zenoh", "matplotlib"} & told["needed_bytes"].keys()
    assert all(size > 10_000 for size in told["needed_bytes"].values())
    assert told["heavy"] == []
    assert 50 < told["modules"] < 1_000
    assert 0.0 < told["import_s"] < 30.0
    assert told["memory_bytes"] is None or 1e6 < told["memory_bytes"] < 200e6


def test_it_is_told_in_words(capsys: pytest.CaptureFixture[str]) -> None:
    assert footprint.main([]) == 0
    said = capsys.readouterr().out
    assert "no numpy" in said
    assert "pydantic-core" in said


def test_something_heavy_is_told_and_is_an_error(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr(footprint, "_HEAVY", ("numpy", "httpx2"))
    assert footprint.main([]) == 1
    assert "heavy       httpx2" in capsys.readouterr().out
