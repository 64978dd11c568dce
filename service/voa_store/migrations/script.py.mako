"""${message}."""

import sqlalchemy as sa
from alembic import op

revision = ${repr(up_revision)}
down_revision = ${repr(down_revision)}
branch_labels = None
depends_on = None


def upgrade() -> None:
    """Migrate to this revision; there is no way back, because stored responses must stay readable."""
    ${upgrades if upgrades else "pass"}
