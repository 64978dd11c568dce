"""Adds what later looks of a session depend on, and the announced looks that are under way."""

import sqlalchemy as sa
from alembic import op

revision = "0007"
down_revision = "0006"
branch_labels = None
depends_on = None


def upgrade() -> None:
    """Migrate to this revision; checksums of existing rows stay valid. There is no way back."""
    op.add_column("sessions", sa.Column("looks", sa.Text))
    op.add_column("sessions", sa.Column("under_way", sa.Text))
    op.add_column("history", sa.Column("looks", sa.Text))
