"""Environment of Alembic: runs the migrations on the connection that `voa_store.migrate` hands over."""

from alembic import context

from voa_store.tables import metadata

context.configure(connection=context.config.attributes["connection"], target_metadata=metadata)
context.run_migrations()
