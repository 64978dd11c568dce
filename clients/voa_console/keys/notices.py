"""Sentences that a browser shows after it was redirected: its address names them, and does not contain them."""

import secrets
from collections import OrderedDict

MOST = 200
"""Most sentences that are kept."""


class Notices:
    """Sentences by identifiers that nobody can guess."""

    def __init__(self) -> None:
        self._sentences: OrderedDict[str, str] = OrderedDict()

    def put(self, sentence: str) -> str:
        """Keep a sentence; return its identifier."""
        identifier = secrets.token_urlsafe(12)
        self._sentences[identifier] = sentence
        while len(self._sentences) > MOST:
            self._sentences.popitem(last=False)
        return identifier

    def get(self, identifier: str) -> str:
        """Return a sentence; "": there is none with that identifier, or no longer."""
        return self._sentences.get(identifier, "")
