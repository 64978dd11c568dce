"""`voa demo` tells the paper's story and leaves the picture."""

from pathlib import Path

import pytest

from voa_cli.main import main

PNG = b"\x89PNG\r\n\x1a\n"


def test_the_demo_tells_how_one_look_changes_the_grasp(capfd: pytest.CaptureFixture[str], tmp_path: Path) -> None:
    out = tmp_path / "demo"
    assert main(["demo", "--out", str(out)]) == 0
    told = " ".join(capfd.readouterr().out.split())
    before, after = told.split("The lidar looks from")
    assert "TD90" in before
    assert "40% of cases" in before
    assert "expected score" in before
    assert "0.40" in before
    assert "Value of Assistance" in before
    assert "The mug is really at U_90" in after
    assert "The best grasp is now OI90" in after
    picture = out / "before-and-after.png"
    assert picture.name in told.replace(" ", "")
    content = picture.read_bytes()
    assert content.startswith(PNG)
    assert len(content) > 10_000
