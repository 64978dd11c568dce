"""What the client costs a robot: `python -m tests.benchmarks.footprint [--json]`.

Measured, not remembered: the size of the base install (this distribution and what it needs without extras) from the
installed files; modules, time and memory of `import voa_client` from fresh interpreters, the best of several.
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
        with open("/proc/self/statm") as told:
            return int(told.read().split()[1])
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
    """What was measured.

    Attributes:
        own_bytes: of each package of this distribution on disk, bytecode left out.
        needed_bytes: of each distribution that the base install needs besides.
        modules: how many `import voa_client` loads.
        import_s: how long that takes.
        memory_bytes: by how much it makes the process larger; None where that cannot be read.
        heavy: those of numpy, Zenoh's library and the like that it loads; none, if all is well.
    """

    own_bytes: dict[str, int]
    needed_bytes: dict[str, int]
    modules: int
    import_s: float
    memory_bytes: int | None
    heavy: list[str]


def measure() -> Footprint:
    """Measure this install; starts interpreters."""
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
    """Print the footprint; returns 1 if something heavy is loaded."""
    parser = argparse.ArgumentParser(prog="python -m tests.benchmarks.footprint", description=(__doc__ or ""))
    parser.add_argument("--json", action="store_true", help="print one JSON document")
    options = parser.parse_args(arguments)
    found = measure()
    if options.json:
        print(json.dumps(asdict(found)))
    else:
        print("\n".join(_told(found)))
    return 1 if found.heavy else 0


def _told(found: Footprint) -> list[str]:
    own, needed = sum(found.own_bytes.values()), sum(found.needed_bytes.values())
    robot = sum(size for name, size in found.own_bytes.items() if name in _ROBOT)
    memory = "cannot be read here" if found.memory_bytes is None else f"{_megabytes(found.memory_bytes)} more"
    return [
        f"installed   {_megabytes(own + needed)}: this distribution {_megabytes(own)}, of which {' and '.join(_ROBOT)} "
        f"{_megabytes(robot)}; and what it needs:",
        *(f"{_megabytes(size):>18}  {name}" for name, size in sorted(found.needed_bytes.items(), key=_by_size)),
        f"imported    {found.modules} modules in {1e3 * found.import_s:.0f} ms",
        f"memory      {memory}",
        f"heavy       {', '.join(found.heavy) or 'nothing: no numpy, and no Zenoh until it is used'}",
    ]


def _by_size(item: tuple[str, int]) -> int:
    return -item[1]


def _megabytes(size: int) -> str:
    return f"{size / 1e6:.2f} MB"


def _own() -> dict[str, int]:
    """The packages of this distribution: also where it is installed as a link to a checkout."""
    found = {}
    for module in pkgutil.iter_modules():
        if module.ispkg and module.name.startswith("voa_"):
            spec = importlib.util.find_spec(module.name)
            folders = [] if spec is None else list(spec.submodule_search_locations or ())
            found[module.name] = sum(_size(path) for folder in folders for path in Path(folder).rglob("*"))
    return found


def _needed() -> dict[str, int]:
    """The distributions that the base install needs, and those that they need, as far as they are installed."""
    found: dict[str, int] = {}
    waiting = _requirements(distribution("voa"))
    while waiting:
        name = waiting.pop()
        if name in found:
            continue
        try:
            installed = distribution(name)
        except PackageNotFoundError:  # another platform or version of Python needs it
            continue
        found[name] = sum(_size(Path(str(file.locate()))) for file in installed.files or ())
        waiting += _requirements(installed)
    return found


def _requirements(installed: Distribution) -> list[str]:
    """Names, without those of extras."""
    told = [each for each in installed.requires or () if "extra ==" not in each]
    return [found[0].lower().replace("_", "-") for each in told if (found := re.match(r"[A-Za-z0-9._-]+", each))]


def _size(path: Path) -> int:
    return path.stat().st_size if path.is_file() and "__pycache__" not in path.parts else 0


def _imported() -> dict[str, Any]:
    """What `import voa_client` does to a fresh interpreter."""
    done = subprocess.run([sys.executable, "-c", _PROBE], capture_output=True, text=True, check=True)
    told: dict[str, Any] = json.loads(done.stdout)
    return told


if __name__ == "__main__":
    sys.exit(main())
