"""Versions on which the digits of a ranking depend."""

import platform
from importlib.metadata import version

from voa_service.versions import differences, versions


def test_the_interpreter_and_what_computes_are_named() -> None:
    named = versions()
    assert named["python"] == platform.python_version()
    assert named["numpy"] == version("numpy")
    assert set(named) == {"python", "voa", "numpy", "numba", "scipy"}


def test_differences_name_both_sides() -> None:
    assert differences({"numpy": "2.2", "voa": "0.2.0"}, {"numpy": "2.4", "voa": "0.2.0"}) == [
        "numpy 2.2 there, 2.4 here"
    ]
    assert differences({}, {"voa": "0.2.0"}) == ["voa None there, 0.2.0 here"]
    assert differences(versions(), versions()) == []
