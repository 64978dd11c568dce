"""Page Now: a card for each session that moved in the last hour.

| module    | contents                                                  |
|-----------|-----------------------------------------------------------|
| `summary` | the texts and bars of a card, from session and robots     |
| `states`  | state of a session in words                               |
| `cards`   | the cards as elements of the page                         |
| `opening` | the dialog that opens a session                           |
| `page`    | the page                                                  |
"""

from voa_console.now import page


def register() -> None:
    """Declare the page `/`."""
    page.register()
