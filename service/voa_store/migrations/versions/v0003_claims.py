"""Adds claims of mapped robots; before this revision the newest session on a robot's scenario received its scans."""

import sqlalchemy as sa
from alembic import op

revision = "0003"
down_revision = "0002"
branch_labels = None
depends_on = None


def upgrade() -> None:
    """Create the table, empty: the next look of a robot claims it for a session. There is no way back."""
    order = sa.BigInteger().with_variant(sa.Integer, "sqlite")
    op.create_table(
        "claims",
        sa.Column("robot", sa.String(128), primary_key=True),
        sa.Column("session", sa.String(64)),
        sa.Column("scenario", sa.String(64)),
        sa.Column("after", order, nullable=False),
    )
