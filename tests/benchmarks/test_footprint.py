"""The footprint of the client is measured, and stays small."""

import json

import pytest

from tests.benchmarks import footprint


def test_the_figures_are_of_this_install(capsys: pytest.CaptureFixture[str]) -> None:
    assert footprint.main(["--json"]) == 0
    measured = json.loads(capsys.readouterr().out)
    assert {"voa_client", "voa_msgs"} <= measured["own_bytes"].keys()
    assert {"httpx2", "pydantic", "pydantic-core"} <= measured["needed_bytes"].keys()
    assert not {"numpy", "fastapi", "eclipse-zenoh", "matplotlib"} & measured["needed_bytes"].keys()
    assert all(size > 10_000 for size in measured["needed_bytes"].values())
    assert measured["heavy"] == []
    assert 50 < measured["modules"] < 1_000
    assert 0.0 < measured["import_s"] < 30.0
    assert measured["memory_bytes"] is None or 1e6 < measured["memory_bytes"] < 200e6


def test_it_is_printed_as_text(capsys: pytest.CaptureFixture[str]) -> None:
    assert footprint.main([]) == 0
    said = capsys.readouterr().out
    assert "no numpy" in said
    assert "pydantic-core" in said


def test_a_large_library_is_reported_as_an_error(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr(footprint, "_HEAVY", ("numpy", "httpx2"))
    assert footprint.main([]) == 1
    assert "heavy       httpx2" in capsys.readouterr().out
