"""Which axis of its file became an object's z; before, none was turned."""

import sqlalchemy as sa
from alembic import op

revision = "0002"
down_revision = "0001"
branch_labels = None
depends_on = None


def upgrade() -> None:
    """One step forward; there is none back."""
    op.add_column("objects", sa.Column("up", sa.String(2), nullable=False, server_default="+Z"))
