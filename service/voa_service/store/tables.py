"""The tables. Times are ISO 8601 in UTC; float arrays are little-endian float64 blobs."""

from sqlalchemy import Column, Float, ForeignKey, Integer, LargeBinary, MetaData, String, Table, Text, UniqueConstraint

metadata = MetaData()

objects = Table(
    "objects",
    metadata,
    Column("seq", Integer, primary_key=True, autoincrement=True),
    Column("id", String(64), nullable=False, unique=True),
    Column("name", Text, nullable=False),
    Column("created_at", String(32), nullable=False),
    Column("vertices", LargeBinary, nullable=False),
    Column("faces", LargeBinary, nullable=False),
)

scenarios = Table(
    "scenarios",
    metadata,
    Column("seq", Integer, primary_key=True, autoincrement=True),
    Column("id", String(64), nullable=False, unique=True),
    Column("name", Text, nullable=False),
    Column("created_at", String(32), nullable=False),
    Column("body", Text, nullable=False),
)

sessions = Table(
    "sessions",
    metadata,
    Column("seq", Integer, primary_key=True, autoincrement=True),
    Column("id", String(64), nullable=False, unique=True),
    Column("scenario", String(64), ForeignKey("scenarios.id"), nullable=False),
    Column("version", Integer, nullable=False),
    Column("belief", LargeBinary, nullable=False),
    Column("prior", LargeBinary, nullable=False),
    Column("last_fit_rmsd_mm", Float),
    Column("created_at", String(32), nullable=False),
    Column("updated_at", String(32), nullable=False),
)

history = Table(
    "history",
    metadata,
    Column("seq", Integer, primary_key=True, autoincrement=True),
    Column("session", String(64), ForeignKey("sessions.id", ondelete="CASCADE"), nullable=False),
    Column("version", Integer, nullable=False),
    Column("kind", String(16), nullable=False),
    Column("at", String(32), nullable=False),
    Column("request", Text, nullable=False),
    Column("report", Text),
    Column("belief", LargeBinary, nullable=False),
    Column("last_fit_rmsd_mm", Float),
    UniqueConstraint("session", "version"),
)

answers = Table(
    "answers",
    metadata,
    Column("scope", String(128), primary_key=True),
    Column("key", String(256), primary_key=True),
    Column("fingerprint", String(64), nullable=False),
    Column("body", Text, nullable=False),
    Column("version", Integer, nullable=False),
)
