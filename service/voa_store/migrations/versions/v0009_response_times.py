"""Adds the times of stored responses, so that old ones can be removed."""

import sqlalchemy as sa
from alembic import op

revision = "0009"
down_revision = "0008"
branch_labels = None
depends_on = None


def upgrade() -> None:
    """Migrate to this revision; existing responses have no time until they are dated. There is no way back."""
    op.add_column("answers", sa.Column("at", sa.BigInteger))
    op.create_index("ix_answers_at", "answers", ["at"])
