import importlib
import runpy
import sys

import pytest

from voa_core import rasterising, warmup

WEIGHING = {
    "squared_distances": "rules.distances",
    "squared_distances_among": "rules.distances",
    "mirror": "rules.distances",
    "mirror_in_panels": "panels",
    "read_panels": "panels",
    "choose_after_panels": "choices",
    "choose_after_rows": "choices",
    "disagreements": "rules.margin",
    "write_log_likelihoods": "mixture_pairs",
}
"""Kernels that weigh scans and choose grasps, for rankings in either precision, and the modules that call them."""
COMPARING = {"_fit_poses": "fits", "_fit_copies": "fits", "_count_returns": "sight", "_miss": "sight"}
"""Kernels that compare a measured scan, and the modules that call them."""


Met = set[tuple[str, str]]
"""Names of kernels, and the type of the floats that they were called with."""


@pytest.fixture
def met(monkeypatch: pytest.MonkeyPatch) -> Met:
    """The kernels that have run."""
    met: Met = set()
    for name, module in (WEIGHING | COMPARING).items():
        plain = getattr(importlib.import_module(f"voa_core.{module}"), name)

        def spying(*arguments: object, name: str = name, plain: object = plain) -> object:
            met.add((name, str(getattr(arguments[0], "dtype", None))))
            return plain(*arguments)  # type: ignore[operator] # a kernel

        monkeypatch.setattr(f"voa_core.{module}.{name}", spying)
    return met


def test_warming_up_runs_every_kernel_in_the_float_types_that_it_is_used_with(met: Met) -> None:
    warmup.warm_up()
    in_both = {(name, dtype) for name in WEIGHING for dtype in ("float32", "float64")}
    assert met == in_both | {(name, "float64") for name in COMPARING}


def test_the_kernels_of_scans_are_loaded_with_the_type_of_scans(met: Met) -> None:
    warmup.load_scan_kernels()
    names = {"_fit_poses", "_count_returns", "_miss", "disagreements", "write_log_likelihoods"}
    assert met == {(name, "float64") for name in names}


def test_it_is_a_command(monkeypatch: pytest.MonkeyPatch) -> None:
    drawn: list[str] = []
    plain = rasterising.rasterise

    def spying(*arguments: object) -> object:
        drawn.append("a prediction")
        return plain(*arguments)  # type: ignore[arg-type] # passed on as they come

    monkeypatch.setattr("voa_core.prediction.rasterise", spying)
    monkeypatch.delitem(sys.modules, "voa_core.warmup")
    runpy.run_module("voa_core.warmup", run_name="__main__")
    assert drawn
