"""`voa backup` copies the database of a running service; PostgreSQL's own tools do it for a PostgreSQL database."""

import json
import os
import subprocess
import sys
import threading
from contextlib import closing
from pathlib import Path

import pytest

from tests.support.api_keys import make_key, revoke_key
from tests.support.postgres import Server, binaries
from tests.support.replicas import replicas
from tests.support.serving import data_scenario
from voa_client import Client
from voa_msgs.scenarios import ScenarioRequest
from voa_msgs.sessions import BeliefRequest, SessionRequest
from voa_service.backup import main
from voa_store.starting import open_keys


def opened(client: Client) -> str:
    scenario = client.create_scenario(ScenarioRequest.model_validate(data_scenario()))
    return client.create_session(SessionRequest(scenario=scenario.id)).id


def test_every_write_that_was_answered_before_the_backup_is_in_it(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    url = f"sqlite:///{tmp_path / 'voa.db'}"
    answered, stop = [0], threading.Event()
    with replicas(url, tmp_path) as (replica,), Client(replica.url) as client:
        session = opened(client)

        def writing() -> None:
            with Client(replica.url) as own:
                while not stop.is_set():
                    written = own.put_belief(session, BeliefRequest(belief=[0.2, 0.3, 0.5]))
                    assert written.version is not None
                    answered.append(written.version)

        writer = threading.Thread(target=writing)
        writer.start()
        try:
            before = answered[-1]
            code = main([str(tmp_path / "backup.db"), "--database-url", url, "--json"])
            after = answered[-1]
        finally:
            stop.set()
            writer.join()
    assert code == 0
    printed = json.loads(capsys.readouterr().out)
    assert printed["verified"]["sessions"] == 1
    assert before < printed["verified"]["versions"] <= after + 3
    assert printed["size"] == (tmp_path / "backup.db").stat().st_size
    with replicas(f"sqlite:///{tmp_path / 'backup.db'}", tmp_path) as (replica,), Client(replica.url) as client:
        assert client.get_session(session).version == printed["verified"]["versions"] - 1


def test_a_person_reads_one_line(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    url = f"sqlite:///{tmp_path / 'voa.db'}"
    with replicas(url, tmp_path) as (replica,), Client(replica.url) as client:
        opened(client)
    assert main([str(tmp_path / "b.db"), "--database-url", url]) == 0
    size = f"{(tmp_path / 'b.db').stat().st_size / 1e6:.1f} MB"
    assert capsys.readouterr().out == f"{tmp_path}/b.db: {size}, 1 sessions with 1 versions, all undamaged\n"
    assert main([str(tmp_path / "b.db"), "--database-url", url]) == 1
    assert capsys.readouterr().err == f"voa backup: {tmp_path}/b.db exists: name another file, or add --replace\n"
    assert main([str(tmp_path / "b.db"), "--database-url", url, "--replace"]) == 0
    assert main([str(tmp_path / "c.db"), "--database-url", "postgresql://somebody@nowhere/voa"]) == 1
    assert "pg_dump --format=custom --file=FILE URL" in capsys.readouterr().err


def test_the_database_is_that_of_the_setting(tmp_path: Path) -> None:
    environment = os.environ | {"VOA_DATABASE_URL": f"sqlite:///{tmp_path / 'voa.db'}"}
    run = subprocess.run(
        [sys.executable, "-m", "voa_cli.main", "backup", "b.db"],
        env=environment,
        cwd=tmp_path,
        capture_output=True,
        text=True,
        check=False,
    )
    assert run.returncode == 1
    assert run.stderr == f"voa backup: there is no database {tmp_path / 'voa.db'}: name it with --database-url\n"


def test_postgresql_is_backed_up_and_restored_by_the_documented_commands(postgres: Server, tmp_path: Path) -> None:
    url, other = postgres.new_database(), postgres.new_database()
    with replicas(url, tmp_path) as (replica,), Client(replica.url) as client:
        session = opened(client)
        subprocess.run([binaries() / "pg_dump", "--format=custom", f"--file={tmp_path / 'voa.dump'}", url], check=True)
    subprocess.run(
        [binaries() / "pg_restore", "--clean", "--if-exists", f"--dbname={other}", tmp_path / "voa.dump"], check=True
    )
    with replicas(other, tmp_path) as (replica,), Client(replica.url) as client:
        assert client.get_session(session).version == 0
    verified = subprocess.run(
        [sys.executable, "-m", "voa_store.verify", other], capture_output=True, text=True, check=True
    )
    assert json.loads(verified.stdout)["sessions"] == 1


def test_the_documented_commands_leave_the_keys_of_postgresql_as_they_are(postgres: Server, tmp_path: Path) -> None:
    """A restored table of keys would make revoked keys valid again, and remove those that were made since."""
    url, dump, listed = postgres.new_database(), tmp_path / "voa.dump", tmp_path / "voa.list"
    old = make_key(url, "viewer")
    subprocess.run([binaries() / "pg_dump", "--format=custom", f"--file={dump}", url], check=True)
    revoke_key(url, old)
    make_key(url, "operator")
    restore = binaries() / "pg_restore"
    contents = subprocess.run([restore, "--list", dump], check=True, capture_output=True, text=True).stdout
    listed.write_text("".join(line for line in contents.splitlines(keepends=True) if " api_keys" not in line))
    subprocess.run([restore, "--clean", "--if-exists", f"--use-list={listed}", f"--dbname={url}", dump], check=True)
    with closing(open_keys(url)) as store:
        assert [(key.role, key.revoked_at is None) for key in store.list_keys()] == [
            ("viewer", False),
            ("operator", True),
        ]
