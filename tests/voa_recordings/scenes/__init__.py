"""Messages that show the versions of a session."""
