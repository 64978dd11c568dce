"""Recordings: experiments measured by hand, files of sessions, and what robots publish, read, written and replayed."""
