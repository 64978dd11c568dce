"""The units of `deploy/systemd`: systemd has no complaint, they run hardened, and name what the service knows."""

import re
import subprocess
from pathlib import Path

import pytest

from tests.deploy.variables import variables
from voa_cli.console import main as console
from voa_service.settings import Settings

SYSTEMD = Path(__file__).resolve().parents[2] / "deploy" / "systemd"
UNITS = sorted(path.name for path in SYSTEMD.glob("*.service"))
TARGETS = ("basic", "multi-user", "network-online", "shutdown", "sysinit")
MOST_EXPOSED = 20
"""Tenths of the exposure level of `systemd-analyze security`, from 0 to 100; a unit without a restriction has 96."""


def unit(name: str) -> dict[str, list[str]]:
    """The values of each key of a unit."""
    values: dict[str, list[str]] = {}
    for key, value in re.findall(r"(?m)^(\w+)=(.*)$", (SYSTEMD / name).read_text(encoding="utf-8")):
        values.setdefault(key, []).append(value)
    return values


def analyze(*arguments: str) -> subprocess.CompletedProcess[str]:
    return subprocess.run(["systemd-analyze", *arguments], capture_output=True, text=True, check=False, timeout=60)


def machine(folder: Path, units: dict[str, str]) -> Path:
    """A root with the units, and with the commands and targets that they name."""
    for name, text in units.items():
        for command in re.findall(r"(?m)^Exec\w+=(/\S+)", text):
            file = folder / command.lstrip("/")
            file.parent.mkdir(parents=True, exist_ok=True)
            file.touch(mode=0o755)
        file = folder / "etc/systemd/system" / name
        file.parent.mkdir(parents=True, exist_ok=True)
        file.write_text(text, encoding="utf-8")
    targets = folder / "usr/lib/systemd/system"
    targets.mkdir(parents=True)
    for target in TARGETS:
        (targets / f"{target}.target").write_text(f"[Unit]\nDescription={target}\n", encoding="utf-8")
    (folder / "etc/passwd").write_text("voa:x:999:999::/:/usr/sbin/nologin\n", encoding="utf-8")
    (folder / "etc/group").write_text("voa:x:999:\n", encoding="utf-8")
    return folder


def verified(root: Path) -> str:
    done = analyze("verify", f"--root={root}", *UNITS)
    return done.stdout + done.stderr + (f"exit code {done.returncode}" if done.returncode else "")


def test_systemd_has_no_complaint(tmp_path: Path) -> None:
    units = {name: (SYSTEMD / name).read_text(encoding="utf-8") for name in UNITS}
    assert verified(machine(tmp_path / "good", units)) == ""
    misspelt = units | {"voa.service": units["voa.service"].replace("ProtectHome=", "ProtectHom=")}
    assert "ProtectHom" in verified(machine(tmp_path / "bad", misspelt)), "a mistake is seen"


@pytest.mark.parametrize("name", UNITS)
def test_units_run_hardened(name: str) -> None:
    done = analyze("security", "--offline=true", f"--threshold={MOST_EXPOSED}", "--no-pager", str(SYSTEMD / name))
    assert done.returncode == 0, done.stdout[-2000:]
    assert unit(name)["User"] == ["voa"]
    assert unit(name)["SuccessExitStatus"] == ["143"]
    assert "u voa " in (SYSTEMD / "voa.sysusers").read_text(encoding="utf-8")


def test_the_exposure_of_an_open_unit_is_too_high(tmp_path: Path) -> None:
    file = tmp_path / "open.service"
    file.write_text("[Service]\nExecStart=/bin/true\n", encoding="utf-8")
    assert analyze("security", "--offline=true", f"--threshold={MOST_EXPOSED}", str(file)).returncode != 0


def test_the_service_writes_where_it_may() -> None:
    service = unit("voa.service")
    given = dict(each.split("=", 1) for line in service["Environment"] for each in line.split())
    assert {name for name in given if name.startswith("VOA_")} <= variables(Settings)
    assert given["VOA_DATABASE_URL"] == f"sqlite:////var/lib/{service['StateDirectory'][0]}/voa.db"
    assert given["NUMBA_CACHE_DIR"] == f"/var/cache/{service['CacheDirectory'][0]}"
    assert service["WorkingDirectory"] == [f"/var/lib/{service['StateDirectory'][0]}"]
    assert int(service["TimeoutStopSec"][0]) > Settings.model_fields["stop_seconds"].default


def test_commands_of_the_units_are_those_of_the_program(capsys: pytest.CaptureFixture[str]) -> None:
    assert unit("voa.service")["ExecStart"] == ["/opt/voa/bin/voa serve"]
    (command,) = unit("voa-console.service")["ExecStart"]
    with pytest.raises(SystemExit, match="0"):
        console([*command.split()[2:], "--help"])
    assert "voa console" in capsys.readouterr().out
