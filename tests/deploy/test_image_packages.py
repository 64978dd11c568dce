"""Packages of the service's image: enough for every module, without some that metadata requires and nothing imports."""

import json
import re
import subprocess
import sys
from pathlib import Path

DEPLOY = Path(__file__).resolve().parents[2] / "deploy"
OURS = (
    "voa_core voa_service voa_store voa_connections voa_meshes voa_msgs voa_ros voa_client voa_cli.main voa_cli.serve"
    " voa_cli.doctor voa_cli.sessions voa_doctor"
)
LEFT_OUT = "voa_service.cluster."
"""Modules that need the extra `cluster`, which is in no image: a ranking on a cluster starts from the command line."""
PROGRAM = """
import importlib, json, pkgutil, sys
from importlib.metadata import packages_distributions

allowed, ours = set(json.loads(sys.argv[1])), sys.argv[2].split()

class Refusal:
    def __init__(self):
        normal = lambda name: name.lower().replace("_", "-").replace(".", "-")
        self.of = {name: set(map(normal, some)) for name, some in packages_distributions().items()}
    def find_spec(self, name, path=None, target=None):
        top = name.partition(".")[0]
        if self.of.get(top, set()) and not self.of[top] & allowed and not top.startswith("voa_"):
            raise ModuleNotFoundError(f"No module named {name!r}: the image has no {top}", name=name)

sys.meta_path.insert(0, Refusal())
for name in ours:
    package = importlib.import_module(name)
    for module in pkgutil.walk_packages(getattr(package, "__path__", []), name + "."):
        skipped = module.name.startswith(sys.argv[3]) or ".versions." in module.name
        if not skipped and not module.name.endswith(("__main__", ".env")):
            importlib.import_module(module.name)
print(len(sys.modules))
"""


def pins(name: str) -> set[str]:
    return set(re.findall(r"(?m)^([a-z0-9.-]+)==", (DEPLOY / f"requirements-{name}.lock").read_text(encoding="utf-8")))


def unused() -> set[str]:
    text = (DEPLOY / "requirements-unused.txt").read_text(encoding="utf-8")
    return {name.replace(".", "-") for name in re.findall(r"(?m)^([a-z0-9.]+);", text)}


def imported(allowed: set[str]) -> subprocess.CompletedProcess[str]:
    command = [sys.executable, "-c", PROGRAM, json.dumps(sorted(allowed)), OURS, LEFT_OUT]
    return subprocess.run(command, capture_output=True, text=True, check=False, cwd=DEPLOY.parent)


def test_every_module_of_the_service_is_imported_with_the_packages_of_its_image() -> None:
    done = imported(pins("service"))
    assert done.returncode == 0, done.stderr[-2000:]


def test_a_package_that_is_missing_is_seen() -> None:
    done = imported(pins("service") - {"limits"})
    assert done.returncode != 0
    assert "the image has no limits" in done.stderr


def test_what_is_not_imported_is_in_no_list_of_the_service() -> None:
    assert unused()
    assert not unused() & (pins("service") | pins("core"))
    assert pins("core") <= pins("service") & pins("fleet")
    assert pins("fleet") <= pins("console")
