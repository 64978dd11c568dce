"""Whose session each mapped robot's scans are for; before, every new session on its scenario took them."""

import sqlalchemy as sa
from alembic import op

revision = "0003"
down_revision = "0002"
branch_labels = None
depends_on = None


def upgrade() -> None:
    """One step forward; there is none back. No robot has a session at first: its next look settles on one."""
    order = sa.BigInteger().with_variant(sa.Integer, "sqlite")
    op.create_table(
        "claims",
        sa.Column("robot", sa.String(128), primary_key=True),
        sa.Column("session", sa.String(64)),
        sa.Column("scenario", sa.String(64)),
        sa.Column("after", order, nullable=False),
    )
