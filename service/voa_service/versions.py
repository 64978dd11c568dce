"""Versions on which the digits of a ranking depend."""

import platform
from importlib.metadata import version

_PACKAGES = ("voa", "numpy", "numba", "scipy")


def versions() -> dict[str, str]:
    """Return the versions of Python and of the packages that compute, by name."""
    return {"python": platform.python_version()} | {name: version(name) for name in _PACKAGES}


def differences(theirs: dict[str, str], ours: dict[str, str]) -> list[str]:
    """List the versions that differ, each as "numpy 2.2 there, 2.4 here"."""
    return [f"{name} {theirs.get(name)} there, {here} here" for name, here in ours.items() if theirs.get(name) != here]
