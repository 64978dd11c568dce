"""Adds uploaded mesh files, so that a client can find the mesh of a file that was uploaded before."""

import sqlalchemy as sa
from alembic import op

revision = "0004"
down_revision = "0003"
branch_labels = None
depends_on = None


def upgrade() -> None:
    """Create the table, empty: files from before this revision are uploaded again. There is no way back."""
    op.create_table(
        "uploads",
        sa.Column("sha256", sa.String(64), primary_key=True),
        sa.Column("type", sa.String(8), primary_key=True),
        sa.Column("scale", sa.Double, primary_key=True),
        sa.Column("up", sa.String(2), primary_key=True),
        sa.Column("object", sa.String(64), sa.ForeignKey("objects.id", ondelete="CASCADE"), nullable=False),
    )
