"""Alembic's revisions of the tables; `voa_store.migrate` runs them when the service starts."""
