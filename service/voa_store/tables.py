"""The tables. Times are ISO 8601 in UTC; float arrays are little-endian float64 blobs."""

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
"""SQLite counts up in INTEGER alone, of 64 bits."""

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
"""The version of a session that was deleted and whose rows are still being removed: nobody may see it."""

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
)
"""`summary` is what lists show of the belief, null in rows from before it was kept; `newest` is the checksum of the
newest row of the history, `checksum` that of this row (`store.checksums`)."""

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

answers = Table(
    "answers",
    metadata,
    Column("scope", String(128), primary_key=True),
    Column("key", String(256), primary_key=True),
    Column("fingerprint", String(64), nullable=False),
    Column("body", Text, nullable=False),
    Column("version", Integer, nullable=False),
)

claims = Table(
    "claims",
    metadata,
    Column("robot", String(128), primary_key=True),
    Column("session", String(64)),
    Column("scenario", String(64)),
    Column("after", Sequence, nullable=False),
)
"""A mapped robot's session, by id alone: it may be deleted, and what was opened before it (`after`: its `seq`) is then
never taken up again. `scenario` is the session's; both are null where the robot's scans are for nobody."""

uploads = Table(
    "uploads",
    metadata,
    Column("sha256", String(64), primary_key=True),
    Column("type", String(8), primary_key=True),
    Column("scale", Double, primary_key=True),
    Column("up", String(2), primary_key=True),
    Column("object", String(64), ForeignKey("objects.id", ondelete="CASCADE"), nullable=False),
)
"""The mesh that a file became: its bytes, its type, and how it was read."""

summaries = Table(
    "summaries",
    metadata,
    Column("id", String(64), primary_key=True),
    Column("summary", Text, nullable=False),
)
"""Facts that lists show of an object or a scenario, by its digest, as JSON: its own row holds megabytes."""

probes = Table(
    "probes",
    metadata,
    Column("replica", String(64), primary_key=True),
    Column("filler", LargeBinary, nullable=False),
)
"""A row of each process, written again and again to see whether writes work."""
