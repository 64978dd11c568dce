"""Imports point one way (deploy/docs/where-is-what.md): the sources are parsed, and nothing is imported."""

import ast
import fnmatch
import sys
from dataclasses import dataclass, field
from pathlib import Path

import pytest

REPOSITORY = Path(__file__).resolve().parents[2]

STDLIB = "<stdlib>"
PYDANTIC = ("pydantic", "pydantic_core", "annotated_types")
"""Packages that an installation of pydantic brings."""


@dataclass(frozen=True)
class Package:
    """Imports that a package may have: top-level names, and names that only some of its files may import.

    Attributes:
        folder: where it stands in the repository.
        may: top-level names; `STDLIB` for the standard library.
        only_in: names that only files whose own name fits one of some patterns may import, with spaces between them.
    """

    folder: str
    may: frozenset[str]
    only_in: dict[str, str] = field(default_factory=dict)


def _package(folder: str, *may: str, only_in: dict[str, str] | None = None) -> Package:
    return Package(folder, frozenset(may), only_in or {})


def _fits(file: str, patterns: str) -> bool:
    return any(fnmatch.fnmatch(Path(file).name, pattern) for pattern in patterns.split())


PACKAGES = {
    "voa_core": _package(
        "voa_core",
        STDLIB,
        "numpy",
        "scipy",
        only_in={
            "filterpy": "filtering.py",
            "numba": "jit.py register_products.py",
            "llvmlite": "register_products.py",
        },
    ),
    "voa_msgs": _package("clients/voa_msgs", STDLIB, *PYDANTIC),
    "voa_ros": _package("clients/voa_ros", STDLIB, *PYDANTIC, "voa_msgs", "voa_scene", only_in={"zenoh": "latched.py"}),
    "voa_scene": _package("clients/voa_scene", STDLIB, "voa_msgs"),
    "voa_client": _package("clients/voa_client", STDLIB, *PYDANTIC, "voa_msgs", "httpx2", "zenoh"),
    "voa_recordings": _package(
        "clients/voa_recordings",
        STDLIB,
        *PYDANTIC,
        "voa_client",
        "voa_msgs",
        "voa_ros",
        "voa_scene",
        "mcap",
        "rosbags",
        "zenoh",
        only_in={"numpy": "scene_message.py series.py", "ruamel": "folder.py", "zstandard": "packed.py"},
    ),
    "voa_doctor": _package(
        "clients/voa_doctor",
        STDLIB,
        *PYDANTIC,
        "voa_client",
        "voa_msgs",
        "voa_recordings",
        "voa_ros",
        "httpx2",
        "zenoh",
    ),
    "voa_fleet": _package(
        "clients/voa_fleet",
        STDLIB,
        *PYDANTIC,
        "voa_client",
        "voa_msgs",
        "voa_recordings",
        "voa_ros",
        "voa_assets",
        "OpenGL",
        "PIL",
        "jinja2",
        "matplotlib",
        "mujoco",
        "numpy",
        "rich",
        "scipy",
    ),
    "voa_evaluation": _package(
        "clients/voa_evaluation",
        STDLIB,
        *PYDANTIC,
        "voa_client",
        "voa_core",
        "voa_fleet",
        "voa_msgs",
        "voa_recordings",
        "voa_ros",
        "voa_assets",
        "jinja2",
        "matplotlib",
        "mujoco",
        "numpy",
        "rich",
        "scipy",
    ),
    "voa_setup": _package(
        "clients/voa_setup",
        STDLIB,
        *PYDANTIC,
        "voa_client",
        "voa_core",
        "voa_fleet",
        "voa_msgs",
        "voa_recordings",
        "voa_ros",
        "voa_assets",
        "jinja2",
        "manifold3d",
        "matplotlib",
        "mujoco",
        "numpy",
        "rich",
        "scipy",
        "trimesh",
    ),
    "voa_console": _package(
        "clients/voa_console",
        STDLIB,
        *PYDANTIC,
        "voa_client",
        "voa_doctor",
        "voa_msgs",
        "voa_recordings",
        "voa_ros",
        "voa_scene",
        "voa_setup",
        "voa_assets",
        "fastapi",
        "nicegui",
        "starlette",
        "uvicorn",
    ),
    "voa_cli": _package(
        "clients/voa_cli",
        STDLIB,
        *PYDANTIC,
        "voa_client",
        "voa_console",
        "voa_doctor",
        "voa_evaluation",
        "voa_fleet",
        "voa_msgs",
        "voa_recordings",
        "voa_ros",
        "voa_setup",
        "voa_assets",
        "httpx2",
        "matplotlib",
        "rich",
        "zenoh",
        only_in={"voa_service": "serve.py"},  # `voa serve` puts the service and the console together
    ),
    "voa_assets": _package(
        "assets/voa_assets",
        STDLIB,
        only_in={"trimesh": "make_*.py", "numpy": "make_*.py", "shapely": "make_*.py"},
    ),
    "voa_meshes": _package(
        "service/voa_meshes",
        STDLIB,
        *PYDANTIC,
        "numpy",
        only_in={"mapbox_earcut": "polygons.py"},
    ),
    "voa_connections": _package(
        "service/voa_connections",
        STDLIB,
        *PYDANTIC,
        "starlette",
        "structlog",
        "uvicorn",
        only_in={"httptools": "connection.py"},
    ),
    "voa_store": _package(
        "service/voa_store",
        STDLIB,
        "voa_core",
        "alembic",
        "numpy",
        "sqlalchemy",
        "structlog",
        only_in={"psycopg": "listening.py patience.py"},
    ),
    "voa_service": _package(
        "service/voa_service",
        STDLIB,
        "voa_connections",
        "voa_core",
        "voa_meshes",
        "voa_msgs",
        "voa_ros",
        "voa_scene",
        "voa_store",
        "voa_assets",
        "fastapi",
        "fastapi_offline",
        "limits",
        "numpy",
        "prometheus_client",
        *PYDANTIC,
        "pydantic_settings",
        "rosbags",
        "starlette",
        "structlog",
        "threadpoolctl",
        "uvicorn",
        "zenoh",
        # `voa rank --cluster` alone, from the extra `cluster`
        only_in={
            "cloudpickle": "sending.py",
            "dask": "connecting.py",
            "distributed": "connecting.py mapping.py",
        },
    ),
}
SHADOWED = {
    "service": "voa_service",
    "clients": "voa_msgs, voa_client or another of clients/",
    "assets": "voa_assets",
}
"""Folders that are no packages: `service` and `clients` exist on PyPI and would win silently."""


def imported(source: str) -> set[str]:
    """Absolute dotted names that a module imports, at the top or within; relative imports stay in the package."""
    names: set[str] = set()
    for node in ast.walk(ast.parse(source)):
        if isinstance(node, ast.Import):
            names |= {alias.name for alias in node.names}
        elif isinstance(node, ast.ImportFrom) and node.level == 0 and node.module:
            names.add(node.module)
        elif isinstance(node, ast.Call) and node.args and isinstance(node.args[0], ast.Constant):
            called = node.func.attr if isinstance(node.func, ast.Attribute) else getattr(node.func, "id", None)
            name = node.args[0].value
            if called in {"import_module", "__import__"} and isinstance(name, str) and not name.startswith("."):
                names.add(name)
    return names


def forbidden(name: str, package: Package, file: str, source: str) -> list[str]:
    """Imports of `source`, the file `file` (relative to the package), that the table does not allow."""
    wrong = []
    for dotted in sorted(imported(source)):
        top = dotted.split(".")[0]
        allowed = (
            top == name
            or top in package.may
            or (STDLIB in package.may and top in sys.stdlib_module_names)
            or (top in package.only_in and _fits(file, package.only_in[top]))
        )
        if not allowed:
            wrong.append(dotted)
    return wrong


def files_of(folder: Path) -> list[Path]:
    return sorted(path for path in folder.rglob("*.py") if "__pycache__" not in path.parts)


def existing() -> list[str]:
    return [name for name, package in PACKAGES.items() if (REPOSITORY / package.folder).is_dir()]


@pytest.mark.parametrize("name", existing())
def test_a_package_imports_only_what_it_may(name: str) -> None:
    package = PACKAGES[name]
    folder = REPOSITORY / package.folder
    files = files_of(folder)
    assert files
    wrong = {
        str(path.relative_to(REPOSITORY)): forbidden_names
        for path in files
        if (forbidden_names := forbidden(name, package, path.relative_to(folder).as_posix(), path.read_text()))
    }
    assert not wrong, f"{name} may import {sorted(package.may)} and, where stated, {package.only_in}"


def test_every_package_of_the_distribution_is_in_the_table() -> None:
    folders = {
        path.parent.relative_to(REPOSITORY).as_posix()
        for base in (".", "service", "clients", "assets")
        for path in (REPOSITORY / base).glob("voa_*/__init__.py")
    }
    assert folders == {package.folder for package in PACKAGES.values() if (REPOSITORY / package.folder).is_dir()}


def test_nobody_imports_a_folder_that_is_no_package() -> None:
    wrong = [
        f"{path.relative_to(REPOSITORY)}: {dotted} (the import name is {SHADOWED[dotted.split('.')[0]]})"
        for base in ("voa_core", "service", "clients", "assets", "tests", "deploy")
        for path in files_of(REPOSITORY / base)
        for dotted in sorted(imported(path.read_text()))
        if dotted.split(".")[0] in SHADOWED
    ]
    assert not wrong


@pytest.mark.parametrize(
    ("name", "file", "source", "wrong"),
    [
        ("voa_core", "poses.py", "import numpy as np\nfrom voa_core.checks import Floats", []),
        ("voa_core", "poses.py", "from pydantic import BaseModel", ["pydantic"]),
        ("voa_core", "poses.py", "import voa_msgs.updates", ["voa_msgs.updates"]),
        ("voa_core", "poses.py", "import filterpy.kalman", ["filterpy.kalman"]),
        ("voa_core", "filtering.py", "from filterpy import discrete_bayes", []),
        ("voa_core", "kernels.py", "from numba import njit", ["numba"]),
        ("voa_core", "poses.py", "def late():\n    import fastapi", ["fastapi"]),
        ("voa_core", "poses.py", "import importlib\nimportlib.import_module('zenoh')", ["zenoh"]),
        ("voa_core", "poses.py", "from . import checks\nfrom .checks import Floats", []),
        ("voa_msgs", "scans.py", "import json\nimport numpy", ["numpy"]),
        ("voa_client", "sync.py", "import voa_service.app\nimport httpx2", ["voa_service.app"]),
        ("voa_cli", "demo.py", "__import__('voa_core')", ["voa_core"]),
        ("voa_service", "app.py", "from voa_client import Client", ["voa_client"]),
        ("voa_fleet", "simulated.py", "import voa_core.prediction, mujoco", ["voa_core.prediction"]),
        ("voa_evaluation", "observation.py", "import voa_core.prediction", []),
        ("voa_evaluation", "observation.py", "import voa_cli.tables", ["voa_cli.tables"]),
        ("voa_setup", "poses.py", "import voa_core.prediction, trimesh", []),
        ("voa_setup", "poses.py", "import voa_evaluation.grasp_scores", ["voa_evaluation.grasp_scores"]),
        ("voa_store", "sql.py", "from voa_service.failures import Failure", ["voa_service.failures"]),
        ("voa_fleet", "devices.py", "from voa_service.app import make", ["voa_service.app"]),
        ("voa_assets", "presets.py", "import trimesh", ["trimesh"]),
        ("voa_assets", "mug/make_mug.py", "import trimesh, shapely.geometry", []),
    ],
)
def test_the_rules_catch_what_they_should(name: str, file: str, source: str, wrong: list[str]) -> None:
    assert forbidden(name, PACKAGES[name], file, source) == wrong
