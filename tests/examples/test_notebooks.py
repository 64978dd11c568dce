"""The notebooks of clients/examples run from top to bottom, and are stored without outputs."""

import json
import os
import subprocess
import sys
from pathlib import Path
from typing import Any

import pytest

from tests.deploy.pages import REPOSITORY

NOTEBOOKS = sorted((REPOSITORY / "clients/examples").glob("*.ipynb"))


def cells(notebook: Path, kind: str) -> list[dict[str, Any]]:
    """Cells of one kind, "code" or "markdown", in order."""
    document = json.loads(notebook.read_text(encoding="utf-8"))
    assert document["nbformat"] == 4
    return [cell for cell in document["cells"] if cell["cell_type"] == kind]


def run(notebook: Path, folder: Path, more: str = "") -> str:
    """Run the code of a notebook as one program, and return what it prints."""
    script = folder / "notebook.py"
    script.write_text("\n\n".join("".join(cell["source"]) for cell in cells(notebook, "code")) + more, encoding="utf-8")
    ended = subprocess.run(
        [sys.executable, str(script)],
        env=os.environ | {"MPLBACKEND": "agg"},
        capture_output=True,
        text=True,
        check=False,
        timeout=120,
    )
    assert ended.returncode == 0, ended.stderr
    return ended.stdout


def test_there_is_a_notebook() -> None:
    assert NOTEBOOKS


@pytest.mark.parametrize("notebook", NOTEBOOKS, ids=lambda path: path.name)
def test_a_notebook_is_stored_without_outputs(notebook: Path) -> None:
    for cell in cells(notebook, "code"):
        assert (cell["outputs"], cell["execution_count"]) == ([], None)


def test_voa_and_aecd_are_those_that_the_experiment_expects(tmp_path: Path) -> None:
    notebook = REPOSITORY / "clients/examples/aecd_of_an_experiment.ipynb"
    more = """
import json
print(json.dumps({name: {"voa": look.voa, "aecd": look.aecd} for name, look in looks.items()}))
print(len(plt.get_fignums()))
"""
    values_line, pictures = run(notebook, tmp_path, more).splitlines()[-2:]
    results = json.loads(values_line)
    expected = json.loads((REPOSITORY / "assets/voa_assets/experiments/mug/expected.json").read_text())["rules"]
    assert set(results) == set(expected["inverse_rmsd"])
    for sensor, values in expected["inverse_rmsd"].items():
        assert results[sensor]["voa"] == pytest.approx(values["voa"], abs=1e-6)
        assert results[sensor]["aecd"] == pytest.approx(values["aecd"], abs=1e-6)
    assert pictures == "1"
