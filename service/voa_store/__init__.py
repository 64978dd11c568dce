"""Durable storage of scenarios, sessions and histories in SQLite or PostgreSQL, by SQLAlchemy Core.

`starting.open_store` opens it; `sql.SqlStore` implements the service's port `Store`; `records` defines the stored
records, and `errors` the errors. All calls are synchronous, and are made from worker threads.
"""
