"""Which mesh files were uploaded, so that a client can ask before it uploads one again."""

import sqlalchemy as sa
from alembic import op

revision = "0004"
down_revision = "0003"
branch_labels = None
depends_on = None


def upgrade() -> None:
    """One step forward; there is none back. What was uploaded before is not known: it is uploaded once more."""
    op.create_table(
        "uploads",
        sa.Column("sha256", sa.String(64), primary_key=True),
        sa.Column("type", sa.String(8), primary_key=True),
        sa.Column("scale", sa.Double, primary_key=True),
        sa.Column("up", sa.String(2), primary_key=True),
        sa.Column("object", sa.String(64), sa.ForeignKey("objects.id", ondelete="CASCADE"), nullable=False),
    )
