"""Tables of the database. Times are ISO 8601 texts in UTC; float arrays are little-endian float64 blobs."""

from sqlalchemy import (
    BigInteger,
    Column,
    Double,
    Float,
    ForeignKey,
    Integer,
    LargeBinary,
    MetaData,
    String,
    Table,
    Text,
)

metadata = MetaData()

Sequence = BigInteger().with_variant(Integer, "sqlite")
"""Type of numbers that the database counts up; SQLite does so only for INTEGER, which has 64 bits there."""

objects = Table(
    "objects",
    metadata,
    Column("seq", Sequence, primary_key=True, autoincrement=True),
    Column("id", String(64), nullable=False, unique=True),
    Column("name", Text, nullable=False),
    Column("created_at", String(32), nullable=False),
    Column("vertices", LargeBinary, nullable=False),
    Column("faces", LargeBinary, nullable=False),
    Column("up", String(2), nullable=False, server_default="+Z"),
)

scenarios = Table(
    "scenarios",
    metadata,
    Column("seq", Sequence, primary_key=True, autoincrement=True),
    Column("id", String(64), nullable=False, unique=True),
    Column("name", Text, nullable=False),
    Column("created_at", String(32), nullable=False),
    Column("body", Text, nullable=False),
)

GONE = -1
"""Version that marks a deleted session whose rows are still being removed: no query may return it."""

sessions = Table(
    "sessions",
    metadata,
    Column("seq", Sequence, primary_key=True, autoincrement=True),
    Column("id", String(64), nullable=False, unique=True),
    Column("scenario", String(64), ForeignKey("scenarios.id"), nullable=False),
    Column("version", Integer, nullable=False),
    Column("belief", LargeBinary, nullable=False),
    Column("prior", LargeBinary, nullable=False),
    Column("last_fit_rmsd_mm", Float),
    Column("created_at", String(32), nullable=False),
    Column("updated_at", String(32), nullable=False),
    Column("summary", Text),
    Column("newest", LargeBinary),
    Column("checksum", LargeBinary),
    Column("looks", Text),
    Column("under_way", Text),
)
"""Sessions at their newest version. `summary` holds the facts about the belief that lists show, null in rows from
before it was stored; `newest` is the checksum of the newest row of the history, `checksum` that of this row; `looks` is
described by `records.SessionState`; `under_way`, which no checksum covers, holds announced looks, as JSON."""

history = Table(
    "history",
    metadata,
    Column("session", String(64), ForeignKey("sessions.id", ondelete="CASCADE"), primary_key=True),
    Column("version", Integer, primary_key=True, autoincrement=False),
    Column("kind", String(16), nullable=False),
    Column("at", String(32), nullable=False),
    Column("request", Text, nullable=False),
    Column("report", Text),
    Column("belief", LargeBinary, nullable=False),
    Column("last_fit_rmsd_mm", Float),
    Column("checksum", LargeBinary),
    Column("looks", Text),
)
"""Every version of a session; `checksum` covers the row and the checksum of the version before."""

robot_looks = Table(
    "robot_looks",
    metadata,
    Column("session", String(64), ForeignKey("sessions.id", ondelete="CASCADE"), primary_key=True),
    Column("robot", String(128), primary_key=True),
    Column("number", Sequence, primary_key=True, autoincrement=False),
    Column("digest", String(64), nullable=False),
)

responses = Table(
    "answers",
    metadata,
    Column("scope", String(128), primary_key=True),
    Column("key", String(256), primary_key=True),
    Column("fingerprint", String(64), nullable=False),
    Column("body", Text, nullable=False),
    Column("version", Integer, nullable=False),
    Column("at", BigInteger, index=True),
)
"""Responses that are stored under an idempotency key. `at` is the time, in seconds since 1970; null in rows of a
version of the service that did not store it, until they are dated."""

claims = Table(
    "claims",
    metadata,
    Column("robot", String(128), primary_key=True),
    Column("session", String(64)),
    Column("scenario", String(64)),
    Column("after", Sequence, nullable=False),
)
"""Claims of mapped robots. A session is named by its id without a foreign key, because it may be deleted; the robot
then moves only to sessions that were opened after it (`after` is its `seq`). `scenario` is the session's scenario;
`session` and `scenario` are null where the robot was released from every session."""

uploads = Table(
    "uploads",
    metadata,
    Column("sha256", String(64), primary_key=True),
    Column("type", String(8), primary_key=True),
    Column("scale", Double, primary_key=True),
    Column("up", String(2), primary_key=True),
    Column("object", String(64), ForeignKey("objects.id", ondelete="CASCADE"), nullable=False),
)
"""Meshes by the uploaded file that they were read from: the file's digest, its type, and the options of reading."""

summaries = Table(
    "summaries",
    metadata,
    Column("id", String(64), primary_key=True),
    Column("summary", Text, nullable=False),
)
"""Facts that lists show about an object or a scenario, as JSON, by its digest; its own row may hold megabytes."""

probes = Table(
    "probes",
    metadata,
    Column("replica", String(64), primary_key=True),
    Column("filler", LargeBinary, nullable=False),
)
"""Rows that each process writes and removes to test that the database can be written."""

api_keys = Table(
    "api_keys",
    metadata,
    Column("id", String(32), primary_key=True),
    Column("digest", LargeBinary, nullable=False),
    Column("name", String(64), nullable=False),
    Column("role", String(16), nullable=False),
    Column("sessions", Text),
    Column("robots", Text),
    Column("created_at", String(32), nullable=False),
    Column("expires_at", String(32)),
    Column("revoked_at", String(32)),
    Column("last_used_at", String(32)),
)
"""API keys by the id in their text, with the SHA-256 of the whole text. `sessions` and `robots` are JSON lists, null
for any. A revoked key keeps its row: a service for which a key was ever made stays closed to callers without one."""
