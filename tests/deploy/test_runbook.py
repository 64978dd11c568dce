"""Every command of the runbook is run, every alert has its section, and every quoted log line and metric exists."""

import os
import re
import shlex
import socket
import subprocess
import sys
from collections.abc import Iterator
from contextlib import ExitStack
from pathlib import Path
from threading import Thread
from urllib.parse import urlsplit

import httpx2
import pytest
import uvicorn
import yaml  # type: ignore[import-untyped] # the library has no types
from markdown.extensions.toc import slugify  # type: ignore[import-untyped] # the library has no types

from tests.deploy.pages import REPOSITORY, page
from tests.deploy.test_monitoring import MAKER, MONITORING, existing, rules
from tests.support.postgres import Server, binaries
from tests.support.waiting import wait_for
from tests.voa_store.samples import NOON
from voa_cli.main import main
from voa_service.bootstrap import services
from voa_service.http.app import create_app
from voa_service.settings import Settings
from voa_store.records import StoredKey
from voa_store.sql import SqlStore

RUNBOOK = page("runbook")
BLOCK = re.compile(r"^( *)```sh\n(.*?)^ *```$", re.MULTILINE | re.DOTALL)
ROBOTS = """
[[robot]]
name = "tb3_1"
scenario = "mug"
scans = {topic = "tb3_1/scan"}
pose = {sensor = "Q1"}
"""
NOT_RUN = ("/opt/voa/bin/pip ", "runuser -u voa -- env NUMBA_CACHE_DIR")
"""Beginnings of the lines that install and compile: the image does both, from the same lock files."""
WITH_URL = ("doctor", "prune", "sessions")
POSTGRESQL = ("pg_dump", "createdb", "export NEW=", "pg_restore", "python -m voa_store.verify")
"""Beginnings of the lines for PostgreSQL."""


def blocks() -> list[str]:
    """Blocks of shell commands, without the indentation of their list."""
    texts = [re.sub(rf"(?m)^{match[1]}", "", match[2]) for match in BLOCK.finditer(RUNBOOK.text)]
    return [text.replace("\\\n", "") for text in texts]


def headings() -> set[str]:
    """Anchors of the headings."""
    return {slugify(heading, "-") for heading in re.findall(r"(?m)^#+ (.*)$", RUNBOOK.text)}


def sections() -> dict[str, str]:
    """Faults with their texts."""
    faults = RUNBOOK.text.split("\n## Faults\n")[1].split("\n## ")[0]
    return dict(part.split("\n", 1) for part in faults.split("\n### ")[1:])


class Machine:
    """A machine with a service under systemd, as far as the runbook uses it.

    The service runs in a thread of this process, on a real port, and is started when a command needs it.

    Args:
        home: stands for the folders that the runbook names; commands run in it.
    """

    def __init__(self, home: Path, monkeypatch: pytest.MonkeyPatch) -> None:
        self.home = home
        self.database = home / "voa.db"
        self.starts = 0
        self._enabled = True
        self._environment = monkeypatch
        self._running = ExitStack()
        self._address: str | None = None
        monkeypatch.chdir(home)

    def stop(self) -> None:
        """End the service, if it runs."""
        self._running.close()
        self._address = None

    def run(self, line: str) -> None:
        """Run one command, which must succeed."""
        for written, here in (("/var/lib/voa", str(self.home)), ("/root/", f"{self.home}/")):
            line = line.replace(written, here)
        match shlex.split(os.path.expandvars(line)):
            case ["export", setting]:
                self._environment.setenv(*setting.split("=", 1))
            case ["runuser", "-u", "voa", "--", "voa", *words] | ["voa", *words]:
                self._voa(words)
            case ["curl", "-s", url]:
                assert httpx2.get(self._url() + urlsplit(url).path).raise_for_status().text
            case ["systemctl", *words]:
                self._systemctl(words)
            case ["journalctl", "-u", "voa", *_]:
                pass  # the log of this process is pytest's
            case ["chown", "-R", "voa:", folder]:
                assert Path(folder) == self.database.parent  # the user is made by the unit's installation
            case ["df", *_] as words:
                subprocess.run(words, check=True, capture_output=True)
            case words:
                pytest.fail(f"nobody knows how to run {words}")

    def _voa(self, words: list[str]) -> None:
        where = ["--url", self._url()] if words[0] in WITH_URL else []
        status = main([*words, *where])
        # Without a router the doctor finds that something is wrong: exit code 1, after a list of what is.
        assert status == 0 or (words[0] == "doctor" and {"--zenoh", "--robots"} & set(words) and status == 1), words

    def _systemctl(self, words: list[str]) -> None:
        match words:
            case ["stop", "voa"]:
                self.stop()
                self._enabled = False
            case ["start", "voa"] | ["enable", "--now", "voa", "voa-console"]:
                self._enabled = True
            case ["restart", "voa"]:
                self.stop()
            case ["status", "voa"]:
                assert self._url()
            case _:
                pytest.fail(f"nobody knows systemctl {words}")

    def _url(self) -> str:
        """Address of the service, which is started if it does not run."""
        assert self._enabled, "the runbook has stopped the service"
        if self._address is None:
            settings = Settings(database_url=f"sqlite:///{self.database}", workers=2, cache_mebibytes=64)
            inside = self._running.enter_context(services(settings))
            listening = self._running.enter_context(socket.create_server(("127.0.0.1", 0)))
            server = uvicorn.Server(uvicorn.Config(create_app(inside), log_config=None))
            thread = Thread(target=server.run, args=([listening],))
            thread.start()
            self._running.callback(thread.join)
            self._running.callback(setattr, server, "should_exit", True)
            wait_for(lambda: server.started, "the service to start")
            self._address = f"http://127.0.0.1:{listening.getsockname()[1]}"
            self.starts += 1
        return self._address


@pytest.fixture
def machine(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[Machine]:
    own = Machine(tmp_path, monkeypatch)
    (tmp_path / "robots.toml").write_text(ROBOTS, encoding="utf-8")
    yield own
    own.stop()


def test_every_command_does_what_is_said(machine: Machine, capsys: pytest.CaptureFixture[str]) -> None:
    SqlStore(f"sqlite:///{machine.database}").close()
    operator = ["--role", "operator", "--out", "operator.key", "--database-url", f"sqlite:///{machine.database}"]
    assert main(["keys", "create", "owner", *operator]) == 0
    lines = [line for block in blocks() for line in block.splitlines() if not line.startswith(NOT_RUN)]
    lines = [line for line in lines if not line.startswith(POSTGRESQL)]
    assert len(lines) > 30
    for line in lines:
        machine.run(line)
    assert machine.starts == 4, "first, restarted, upgraded, restored"
    printed = capsys.readouterr().out
    assert "before-upgrade.db: " in printed
    assert sorted(path.name for path in machine.home.glob("*.before-restore-*"))[:1] == ["voa.db.before-restore-1"]
    assert {"anna.key", "tb3_1.key"} <= {path.name for path in machine.home.glob("*.key")}


def test_the_commands_of_postgresql_restore_what_was_dumped_with_the_present_keys(
    postgres: Server, tmp_path: Path
) -> None:
    url = postgres.new_database()
    store = SqlStore(url)
    for name in ("revoked", "valid"):
        store.put_key(StoredKey(name, b"digest", name, "viewer", NOON))
    path = f"{binaries()}{os.pathsep}{Path(sys.executable).parent}{os.pathsep}{os.environ['PATH']}"
    environment = os.environ | {"PATH": path, "VOA_DATABASE_URL": url}
    lines = [line for block in blocks() for line in block.splitlines() if line.startswith(POSTGRESQL)]
    assert len(lines) == 1 + len(POSTGRESQL)
    subprocess.run(["sh", "-euc", lines[0]], check=True, cwd=tmp_path, env=environment)
    store.revoke_key("revoked", NOON)
    store.close()
    subprocess.run(["sh", "-euc", "\n".join(lines[1:])], check=True, cwd=tmp_path, env=environment)
    restored = SqlStore(f"{url.rsplit('/', 1)[0]}/voa_restored")
    assert {key.name: key.revoked_at for key in restored.list_keys()} == {"revoked": NOON, "valid": None}
    restored.close()


def test_each_alert_has_its_section_and_each_section_leads_on() -> None:
    assert len(sections()) == 10
    for rule in rules():
        file, anchor = rule["annotations"]["runbook"].split("#")
        assert (REPOSITORY / file) == REPOSITORY / RUNBOOK.path
        (text,) = [text for heading, text in sections().items() if slugify(heading, "-") == anchor]
        assert f"Alert `{rule['alert']}`" in text
    named = set(re.findall(r"Alert `(\w+)`", RUNBOOK.text))
    assert named == {rule["alert"] for rule in rules()}
    for heading, text in sections().items():
        assert "**Look at**" in text, heading
    assert set(re.findall(r"\]\(#([^)]+)\)", RUNBOOK.text)) <= headings()


def test_each_alert_has_tests_of_promtool() -> None:
    tests = (MONITORING / "rules.test.yml").read_text(encoding="utf-8")
    assert yaml.safe_load(tests)["rule_files"] == ["rules.yml"]
    tested = set(re.findall(r'alertname(?:=|: )"?(\w+)', tests))
    assert tested == {rule["alert"] for rule in rules()}


def test_every_quoted_line_of_the_log_is_in_the_code() -> None:
    code = "".join(path.read_text(encoding="utf-8") for path in sorted((REPOSITORY / "service").rglob("*.py")))
    after = re.findall(r"\*\*[Ll]og\*\*\s+((?:`[^`]+`(?:, | or |\s)*)+)", RUNBOOK.text)
    quoted = [line for text in after for line in re.findall("`([^`]+)`", text)]
    assert len(quoted) > 12
    assert [line for line in quoted if line not in code] == []


def test_every_metric_and_panel_exists(tmp_path: Path) -> None:
    named = set(re.findall(r"`(voa_[a-z_]+)", RUNBOOK.text)) - {"voa_store"}
    assert named - existing(tmp_path) - {"voa_store_seconds"} == set()
    panels = {panel["title"] for panel in MAKER["dashboard"]()["panels"]}
    listed = RUNBOOK.text.split("### Read the dashboard")[1]
    assert set(re.findall(r"(?m)^- \*([^*]+)\*", listed)) <= panels


def test_it_fits_on_a_phone() -> None:
    """Short lines of commands, no tables, and no section that is longer than some screens."""
    assert "\n|" not in RUNBOOK.text
    assert max(len(line) for block in BLOCK.findall(RUNBOOK.text) for line in block[1].splitlines()) < 80
    assert all(len(text.split()) < 180 for text in sections().values())
