"""Requests before a use case sees them: bodies, limits, idempotency keys, attachments."""
