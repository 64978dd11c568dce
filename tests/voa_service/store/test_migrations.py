"""A database of an earlier version keeps what is in it."""

from datetime import UTC, datetime
from pathlib import Path

from alembic import command
from alembic.config import Config
from sqlalchemy import create_engine, text

from tests.voa_core.worlds import box
from voa_service.store import migrate
from voa_service.store.sql import SqlStore


def test_objects_from_before_up_was_kept_were_read_with_z_up(tmp_path: Path) -> None:
    url, mesh = f"sqlite:///{tmp_path}/old.db", box(0.1, 0.2, 0.3)
    engine = create_engine(url)
    with engine.begin() as connection:
        config = Config()
        config.set_main_option("script_location", str(Path(migrate.__file__).parent / "migrations"))
        config.attributes["connection"] = connection
        command.upgrade(config, "0001")
        insert = (
            "INSERT INTO objects (id, name, created_at, vertices, faces) VALUES (:id, 'box', :at, :vertices, :faces)"
        )
        row = {"id": mesh.digest, "at": datetime(2026, 11, 28, tzinfo=UTC).isoformat()}
        connection.execute(text(insert), row | {"vertices": mesh.vertices.tobytes(), "faces": mesh.faces.tobytes()})
    engine.dispose()
    store = SqlStore(url)
    found = store.get_object(mesh.digest)
    assert found is not None
    assert (found.up, found.object.digest) == ("+Z", mesh.digest)
    store.close()
