"""The installation of a robot has the messages and the client, and none of the service's libraries."""

import os
import re
import subprocess
import sys
import venv
from pathlib import Path

import pytest

VIA = re.compile(r"(?m)^    #(?: via)? +([a-z0-9-]+)$")
REPOSITORY = Path(__file__).resolve().parents[2]
FOOTPRINT = REPOSITORY / "tests" / "benchmarks" / "footprint.py"
BASE = ("httpx2", "pydantic")
HEAVY = ("numpy", "scipy", "numba", "trimesh", "mujoco", "fastapi", "starlette", "uvicorn", "sqlalchemy", "rich")


def closure(lock: str, roots: tuple[str, ...]) -> str:
    """The entries of a lock file that the roots need, with their hashes."""
    entries = re.split(r"\n(?=[A-Za-z0-9])", "\n" + re.sub(r"(?m)^#.*\n", "", lock))
    by_name = {match[1]: entry for entry in entries if (match := re.match(r"\s*([A-Za-z0-9._-]+)==", entry))}
    needed: set[str] = set()
    more = set(roots)
    while more:  # every entry says in comments through what it came
        needed |= more
        more = {name for name, entry in by_name.items() if needed & set(VIA.findall(entry))} - needed
    return "\n".join(by_name[name].strip() for name in sorted(needed))


@pytest.fixture(scope="module")
def python(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """An interpreter with the base install of this checkout alone."""
    folder = tmp_path_factory.mktemp("robot")
    needed = folder / "base.txt"
    needed.write_text(closure((REPOSITORY / "requirements.lock").read_text(encoding="utf-8"), BASE), encoding="utf-8")
    venv.create(folder / "venv", with_pip=False)
    own = folder / "venv" / "bin" / "python"
    environment = {name: value for name, value in os.environ.items() if name != "PYTHONPATH"}
    uv = [str(Path(sys.executable).with_name("uv")), "pip", "install", "--quiet", "--python", str(own)]
    subprocess.run([*uv, "--require-hashes", "-r", str(needed)], check=True, env=environment)
    wheel = ["-m", "hatchling", "build", "-t", "wheel", "-d", str(folder)]
    subprocess.run([sys.executable, *wheel], check=True, cwd=REPOSITORY, env=environment, stdout=subprocess.DEVNULL)
    subprocess.run([*uv, "--no-deps", str(next(folder.glob("*.whl")))], check=True, env=environment)
    return own


def run(python: Path, program: str) -> str:
    """Run a program in this installation alone; returns its output."""
    done = subprocess.run(
        [python, "-I", "-W", "error", "-c", program], capture_output=True, text=True, check=False, cwd=python.parent
    )
    assert done.returncode == 0, done.stderr
    return done.stdout


def test_client_and_messages_import_and_bring_nothing_heavy(python: Path) -> None:
    program = (
        "import sys, importlib, pkgutil, voa_client, voa_msgs\n"
        "for package in (voa_client, voa_msgs):\n"
        "    for module in pkgutil.iter_modules(package.__path__):\n"
        "        importlib.import_module(f'{package.__name__}.{module.name}')\n"
        "print(voa_client.__file__)\n"
        f"print(sorted(set({HEAVY!r}) & set(sys.modules)))\n"
    )
    where, heavy = run(python, program).splitlines()
    assert where.startswith(str(python.parents[1]))
    assert heavy == "[]"


def test_the_base_install_talks_to_a_service(python: Path, process: str, capsys: pytest.CaptureFixture[str]) -> None:
    program = (
        "import runpy\n"
        "from voa_client import Client\n"
        f"main = runpy.run_path({str(FOOTPRINT)!r})['main']\n"
        f"with Client({process!r}) as client:\n"
        "    assert client.lidars().items\n"
        "    print(client.health().status)\n"
        "main([])\n"
    )
    report = run(python, program)
    with capsys.disabled():
        print(f"\nthe base install, in an environment of its own:\n{report}")
    assert report.startswith("ready\n")
    assert re.search(r"installed +[0-9.]+ MB", report)
    assert "heavy       nothing" in report


@pytest.mark.parametrize("name", HEAVY)
def test_a_library_of_the_service_is_not_installed(python: Path, name: str) -> None:
    assert run(python, f"import importlib.util; print(importlib.util.find_spec({name!r}))") == "None\n"


def test_the_command_says_what_is_missing(python: Path) -> None:
    done = subprocess.run([python.with_name("voa"), "serve"], capture_output=True, text=True, check=False)
    assert done.returncode == 1
    assert "pip install 'PATH_TO_CLONE[service]'" in done.stderr
    assert "Traceback" not in done.stderr
