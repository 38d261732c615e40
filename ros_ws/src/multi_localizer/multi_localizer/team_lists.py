"""Which teammates the others were told of, and who is there that nobody was told of.

Each robot writes one note a second to each of its teammates (`team_clocks`), so whom it writes to
is its list of the team.
"""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Collection, Iterable

_ENOUGH = 3
_BEARINGS = re.compile(r"^/(.+)/bearings/robots$")


class TeammateList:
    """The list of the team that one teammate was given, read from whom it writes to.

    Args:
        name: Its namespace.
    """

    def __init__(self, name: str) -> None:
        """Start knowing nothing."""
        self._name = name
        self._written: Counter[str] = Counter()
        self.known: frozenset[str] | None = None
        """What it is; None before a few rounds of notes have come."""

    def take(self, reader: str) -> None:
        """Take whom a note of its is for; of several rounds, as some notes may be lost."""
        self._written[reader] += 1
        if self._written[reader] >= _ENOUGH:
            self.known = frozenset(self._written) | {self._name}
            self._written.clear()


def list_problem(name: str, known: frozenset[str] | None, team: Collection[str]) -> str:
    """Return how a teammate's list differs from this one, in words; "" if it does not."""
    if known is None or known == frozenset(team):
        return ""
    return f"/{name} has the team [{', '.join(sorted(known))}], here it is [{', '.join(team)}]"


def strangers(topics: Iterable[str], team: Collection[str]) -> list[str]:
    """Return namespaces that are not in the team and have `bearings/robots`, sorted."""
    found = (_BEARINGS.match(topic) for topic in topics)
    return sorted({match[1] for match in found if match} - set(team))
