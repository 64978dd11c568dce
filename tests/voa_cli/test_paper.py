"""The paper's example: one look changes the grasp, and the picture of it."""

from pathlib import Path

import pytest

from voa_cli.paper import paper_picture
from voa_client import Client

PNG = b"\x89PNG\r\n\x1a\n"


def test_one_look_changes_the_grasp_as_in_the_paper(process: str, tmp_path: Path) -> None:
    picture = tmp_path / "before-and-after.png"
    with Client(process) as client:
        example = paper_picture(client, picture)
    assert (example.before.best_grasp, example.look, example.after.best_grasp) == ("TD90", "ENE", "OI90")
    assert example.before.expected_score == pytest.approx(0.40, abs=0.005)
    assert example.after.expected_score == pytest.approx(0.64, abs=0.01)
    content = picture.read_bytes()
    assert content.startswith(PNG)
    assert len(content) > 10_000
