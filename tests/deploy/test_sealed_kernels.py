import errno
import json
import runpy
import subprocess
import sys
import tempfile
from pathlib import Path
from typing import Any

import pytest
from numba.core import config
from numba.core.caching import UserProvidedCacheLocator

DEPLOY = Path(__file__).resolve().parents[2] / "deploy"
SealedCacheLocator = runpy.run_path(str(DEPLOY / "sealed_kernels.py"))["SealedCacheLocator"]  # no package: one file
NumbasOwn: Any = UserProvidedCacheLocator


def function() -> None:
    pass


def refuse(*_: object, **__: object) -> Any:
    raise OSError(errno.EROFS, "Read-only file system")


def test_a_cache_that_cannot_be_written_is_read(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.setattr(config, "CACHE_DIR", str(tmp_path))
    writable = NumbasOwn.from_function(function, __file__)
    monkeypatch.setattr(tempfile, "TemporaryFile", refuse)
    assert NumbasOwn.from_function(function, __file__) is None, "then the image needs no locator"
    sealed = SealedCacheLocator.from_function(function, __file__)
    assert sealed.get_cache_path() == writable.get_cache_path()
    assert sealed.get_source_stamp() == writable.get_source_stamp()


def test_the_warm_up_compiles_all_that_the_service_uses(tmp_path: Path) -> None:
    for precision in ("float64", "float32"):
        (tmp_path / precision).mkdir()
    command = [sys.executable, "-m", "tests.deploy.main_job", str(tmp_path)]
    done = subprocess.run(command, capture_output=True, text=True, cwd=DEPLOY.parent, check=False)
    assert done.returncode == 0, done.stderr[-2000:]
    assert json.loads(done.stdout.splitlines()[-1]) == [], (
        "in the image, these calls would fail: extend voa_core/warmup.py"
    )
