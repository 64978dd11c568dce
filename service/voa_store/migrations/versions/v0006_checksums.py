"""Adds checksums of sessions and histories, summaries for lists, and the table for test writes."""

import sqlalchemy as sa
from alembic import op

from voa_store.filling import fill_checksums, fill_summaries

revision = "0006"
down_revision = "0005"
branch_labels = None
depends_on = None


def upgrade() -> None:
    """Migrate to this revision; existing rows get the checksums of their present content. There is no way back."""
    op.add_column("sessions", sa.Column("summary", sa.Text))
    op.add_column("sessions", sa.Column("newest", sa.LargeBinary))
    op.add_column("sessions", sa.Column("checksum", sa.LargeBinary))
    op.add_column("history", sa.Column("checksum", sa.LargeBinary))
    op.create_table(
        "summaries",
        sa.Column("id", sa.String(64), primary_key=True),
        sa.Column("summary", sa.Text, nullable=False),
    )
    op.create_table(
        "probes",
        sa.Column("replica", sa.String(64), primary_key=True),
        sa.Column("filler", sa.LargeBinary, nullable=False),
    )
    fill_checksums(op.get_bind())
    fill_summaries(op.get_bind())
