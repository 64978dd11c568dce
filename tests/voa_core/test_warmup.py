import runpy
import sys

import pytest

from voa_core import kernels, rasterising, warmup

KERNELS = {
    "squared_distances": "distances",
    "squared_distances_among": "distances",
    "disagreements": "margin",
    "mixture_likelihoods": "beam",
}


def test_warming_up_runs_every_kernel_in_both_float_types(monkeypatch: pytest.MonkeyPatch) -> None:
    met: set[tuple[str, str]] = set()
    for name, module in KERNELS.items():
        plain = getattr(kernels, name)

        def spying(*arguments: object, name: str = name, plain: object = plain) -> None:
            met.add((name, str(getattr(arguments[0], "dtype", None))))
            plain(*arguments)  # type: ignore[operator] # a kernel

        monkeypatch.setattr(f"voa_core.rules.{module}.{name}", spying)
    warmup.warm_up()
    assert met == {(name, dtype) for name in KERNELS for dtype in ("float32", "float64")}


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
