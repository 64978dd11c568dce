"""The store behind `ports.Store`: SQLAlchemy Core, synchronous, called from worker threads."""
