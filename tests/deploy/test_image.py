"""`make image` on a machine where the tools that it needs are not installed, without a network."""

import shutil
import stat
import subprocess
from pathlib import Path

import pytest

SCRIPT = Path(__file__).resolve().parents[2] / "deploy" / "image.sh"
NEEDED = ("buildah", "podman", "runc")
OF_EVERY_MACHINE = ("bash", "dirname", "env", "mkdir", "mktemp", "rm", "tail")


class Machine:
    """A machine whose commands are those of a folder, and a clone on it."""

    def __init__(self, folder: Path, user: int = 0) -> None:
        self.commands = folder / "bin"
        self.commands.mkdir()
        self.calls = folder / "calls"
        for name in OF_EVERY_MACHINE:
            installed = shutil.which(name)
            assert installed is not None
            (self.commands / name).symlink_to(installed)
        self.script("id", f"echo {user}")
        self.clone = folder / "clone"
        for part in ("deploy/wheelhouse", ".venv/bin"):
            (self.clone / part).mkdir(parents=True)
        shutil.copy(SCRIPT, self.clone / "deploy")
        python = self.clone / ".venv/bin/python"
        python.write_text("#!/usr/bin/env bash\nexit 9\n", encoding="utf-8")
        python.chmod(python.stat().st_mode | stat.S_IXUSR)

    def script(self, name: str, body: str) -> None:
        """Install a command that does `body`."""
        file = self.commands / name
        file.write_text(f"#!{self.commands}/bash\n{body}\n", encoding="utf-8")
        file.chmod(0o755)

    def make_image(self) -> subprocess.CompletedProcess[str]:
        """Run the script with this machine's commands alone."""
        environment = {"PATH": str(self.commands), "TMPDIR": str(self.clone)}
        script = [str(self.commands / "bash"), str(self.clone / "deploy/image.sh")]
        return subprocess.run(script, env=environment, capture_output=True, text=True, check=False, timeout=60)


@pytest.mark.parametrize("there", [(), ("buildah",), ("podman",), ("podman", "runc"), NEEDED])
def test_what_is_missing_is_installed_and_nothing_else(tmp_path: Path, there: tuple[str, ...]) -> None:
    machine = Machine(tmp_path)
    machine.script("apt-get", f'echo "$*" >>{machine.calls}')
    for name in there:
        machine.script(name, "exit 0")
    done = machine.make_image()
    assert done.returncode == 9, "it goes on to gather wheels, which this clone's Python refuses"
    assert "command not found" not in done.stderr
    missing = [name for name in NEEDED if name not in there]
    if not missing:
        assert not machine.calls.exists()
        return
    update, install = machine.calls.read_text(encoding="utf-8").splitlines()
    assert update.startswith("update")
    assert install.split()[-len(missing) :] == missing
    assert not set(there) & set(install.split())


def test_without_apt_the_command_is_printed(tmp_path: Path) -> None:
    done = Machine(tmp_path).make_image()
    assert done.returncode == 1
    assert "buildah podman runc missing" in done.stderr
    assert "sudo apt-get install --no-install-recommends buildah podman runc" in done.stderr


def test_without_root_the_message_names_sudo(tmp_path: Path) -> None:
    done = Machine(tmp_path, user=1000).make_image()
    assert done.returncode == 1
    assert "sudo make image" in done.stderr
