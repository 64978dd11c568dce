"""Footprint of the client on a robot: `python -m tests.benchmarks.footprint [--json]`.

The size of the base install (this distribution and its dependencies without extras) is measured from the installed
files; modules, time and memory of `import voa_client` in fresh interpreters, the best of several.
"""

import argparse
import importlib.util
import json
import pkgutil
import re
import resource
import subprocess
import sys
from collections.abc import Sequence
from dataclasses import asdict, dataclass
from importlib.metadata import Distribution, PackageNotFoundError, distribution
from pathlib import Path
from typing import Any

_RUNS = 5
_ROBOT = ("voa_client", "voa_msgs")
_HEAVY = ("numpy", "scipy", "zenoh", "fastapi", "matplotlib", "rich")
_PROBE = """
import sys, time, json
def resident():
    try:
        with open("/proc/self/statm") as pages:
            return int(pages.read().split()[1])
    except OSError:
        return None
before, kept, began = set(sys.modules), resident(), time.perf_counter()
import voa_client
seconds = time.perf_counter() - began
pages = None if kept is None else resident() - kept
print(json.dumps({"seconds": seconds, "pages": pages, "modules": sorted(set(sys.modules) - before)}))
"""


@dataclass(frozen=True)
class Footprint:
    """Footprint of the base install and of `import voa_client`.

    Attributes:
        own_bytes: size of each package of this distribution on disk, without bytecode.
        needed_bytes: size of each distribution that the base install depends on.
        modules: number of modules that `import voa_client` loads.
        import_s: duration of the import, seconds.
        memory_bytes: growth of the process by the import; None if it cannot be read on this platform.
        heavy: large libraries that the import loads, such as numpy; expected to be empty.
    """

    own_bytes: dict[str, int]
    needed_bytes: dict[str, int]
    modules: int
    import_s: float
    memory_bytes: int | None
    heavy: list[str]


def measure() -> Footprint:
    """Measure this install, with the import in five fresh interpreters."""
    runs = [_imported() for _ in range(_RUNS)]
    modules, pages = runs[0]["modules"], [run["pages"] for run in runs]
    return Footprint(
        own_bytes=_own(),
        needed_bytes=_needed(),
        modules=len(modules),
        import_s=min(run["seconds"] for run in runs),
        memory_bytes=None if None in pages else min(pages) * resource.getpagesize(),
        heavy=[name for name in _HEAVY if name in modules],
    )


def main(arguments: Sequence[str] | None = None) -> int:
    """Print the footprint, and return 0; 1 if the import loads a large library."""
    parser = argparse.ArgumentParser(prog="python -m tests.benchmarks.footprint", description=(__doc__ or ""))
    parser.add_argument("--json", action="store_true", help="print one JSON document")
    options = parser.parse_args(arguments)
    footprint = measure()
    if options.json:
        print(json.dumps(asdict(footprint)))
    else:
        print("\n".join(_lines(footprint)))
    return 1 if footprint.heavy else 0


def _lines(footprint: Footprint) -> list[str]:
    own, needed = sum(footprint.own_bytes.values()), sum(footprint.needed_bytes.values())
    robot = sum(size for name, size in footprint.own_bytes.items() if name in _ROBOT)
    memory = "cannot be read here" if footprint.memory_bytes is None else f"{_megabytes(footprint.memory_bytes)} more"
    return [
        f"installed   {_megabytes(own + needed)}: this distribution {_megabytes(own)}, of which {' and '.join(_ROBOT)} "
        f"{_megabytes(robot)}; and what it needs:",
        *(f"{_megabytes(size):>18}  {name}" for name, size in sorted(footprint.needed_bytes.items(), key=_by_size)),
        f"imported    {footprint.modules} modules in {1e3 * footprint.import_s:.0f} ms",
        f"memory      {memory}",
        f"heavy       {', '.join(footprint.heavy) or 'nothing: no numpy, and no Zenoh until it is used'}",
    ]


def _by_size(item: tuple[str, int]) -> int:
    return -item[1]


def _megabytes(size: int) -> str:
    return f"{size / 1e6:.2f} MB"


def _own() -> dict[str, int]:
    """Measure the packages of this distribution, also if it is installed as a link to a checkout."""
    sizes = {}
    for module in pkgutil.iter_modules():
        if module.ispkg and module.name.startswith("voa_"):
            spec = importlib.util.find_spec(module.name)
            folders = [] if spec is None else list(spec.submodule_search_locations or ())
            sizes[module.name] = sum(_size(path) for folder in folders for path in Path(folder).rglob("*"))
    return sizes


def _needed() -> dict[str, int]:
    """Measure the dependencies of the base install, and their dependencies, as far as they are installed."""
    sizes: dict[str, int] = {}
    waiting = _requirements(distribution("voa"))
    while waiting:
        name = waiting.pop()
        if name in sizes:
            continue
        try:
            installed = distribution(name)
        except PackageNotFoundError:  # another platform or version of Python needs it
            continue
        sizes[name] = sum(_size(Path(str(file.locate()))) for file in installed.files or ())
        waiting += _requirements(installed)
    return sizes


def _requirements(installed: Distribution) -> list[str]:
    """Return the names of a distribution's dependencies, without those of extras."""
    lines = [each for each in installed.requires or () if "extra ==" not in each]
    return [match[0].lower().replace("_", "-") for each in lines if (match := re.match(r"[A-Za-z0-9._-]+", each))]


def _size(path: Path) -> int:
    return path.stat().st_size if path.is_file() and "__pycache__" not in path.parts else 0


def _imported() -> dict[str, Any]:
    """Import `voa_client` in a fresh interpreter, and return the time, pages of memory and modules."""
    done = subprocess.run([sys.executable, "-c", _PROBE], capture_output=True, text=True, check=True)
    measured: dict[str, Any] = json.loads(done.stdout)
    return measured


if __name__ == "__main__":
    sys.exit(main())
