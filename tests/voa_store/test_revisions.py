"""The names of the revisions are those that Alembic finds, and say which tables a process can work with."""

from pathlib import Path

import pytest
from alembic.config import Config
from alembic.script import ScriptDirectory

from tests.support.releases import at_revision
from voa_store import migrate
from voa_store.engines import connect
from voa_store.revisions import REVISIONS, current, generation, is_current, newest


def test_the_names_are_those_that_alembic_finds_in_their_order() -> None:
    config = Config()
    config.set_main_option("script_location", str(Path(migrate.__file__).parent / "migrations"))
    scripts = ScriptDirectory.from_config(config)
    assert tuple(script.revision for script in scripts.walk_revisions())[::-1] == REVISIONS
    assert scripts.get_current_head() == newest()


def test_the_revision_of_a_database_is_the_one_that_alembic_has_noted(database_url: str) -> None:
    engines = connect(database_url)
    for revision in (None, "0008", newest()):
        if revision is not None:
            at_revision(database_url, revision).dispose()
        with engines.single.connect() as connection:
            assert current(connection) == revision
            assert is_current(connection) == (revision == newest())
    engines.dispose()


@pytest.mark.parametrize(("revision", "letters"), [("0009", ""), ("b0012", "b"), ("bb10", "bb")])
def test_a_generation_is_named_by_the_letters_before_a_number(revision: str, letters: str) -> None:
    assert generation(revision) == letters
