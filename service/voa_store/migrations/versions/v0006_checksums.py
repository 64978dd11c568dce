"""Checksums of sessions and their histories, summaries for lists, and rows to try writing with."""

import sqlalchemy as sa
from alembic import op

from voa_store.filling import fill_checksums, fill_summaries

revision = "0006"
down_revision = "0005"
branch_labels = None
depends_on = None


def upgrade() -> None:
    """One step forward; there is none back. What is there is taken as it is, and protected from now on."""
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
