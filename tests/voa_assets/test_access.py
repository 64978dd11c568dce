"""The data can be found by name, with the standard library alone, and nothing is read on import."""

import subprocess
import sys

import pytest

from voa_assets import path


@pytest.mark.parametrize("name", ["mug", "mug/mug.obj", "mallet", "block/physics.json", "experiments/mug", "lidars"])
def test_an_asset_has_a_path(name: str) -> None:
    assert path(name).exists()


@pytest.mark.parametrize("name", ["teapot", "..", "../voa_assets/../../README.md"])
def test_what_is_not_an_asset_is_refused_with_what_there_is(name: str) -> None:
    with pytest.raises(FileNotFoundError, match="block, coupling, experiments/mug, goblet, lidars, mallet, mug"):
        path(name)


def test_importing_reads_nothing_and_needs_the_standard_library_alone() -> None:
    program = (
        "import builtins, pathlib, sys\n"
        "import voa_assets\n"
        "before = set(sys.modules)\n"
        "assert not {'numpy', 'trimesh', 'voa_core', 'pydantic'} & before, before\n"
        "assert len(voa_assets.lidar_presets()) > 1\n"
        "assert not {'numpy', 'trimesh', 'voa_core', 'pydantic'} & set(sys.modules)\n"
    )
    search = [str(path("mug").parent.parent)]
    subprocess.run([sys.executable, "-I", "-c", f"import sys; sys.path[:0] = {search!r}\n{program}"], check=True)
