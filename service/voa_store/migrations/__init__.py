"""Alembic's revisions of the tables; `store.migrate` runs them when the service starts."""
