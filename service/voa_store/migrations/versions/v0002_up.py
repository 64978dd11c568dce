"""Adds the axis of an object's file that became z; before this revision no mesh was turned."""

import sqlalchemy as sa
from alembic import op

revision = "0002"
down_revision = "0001"
branch_labels = None
depends_on = None


def upgrade() -> None:
    """Migrate to this revision; there is no way back."""
    op.add_column("objects", sa.Column("up", sa.String(2), nullable=False, server_default="+Z"))
