"""Who else sends a transform that one node alone should own.

TF messages carry no author. What a node sent itself comes back to it with everything else, so a
sample of our transform that we did not send is somebody else's.
"""

from __future__ import annotations

from collections import OrderedDict

_KEPT = 400  # 20 s of map->odom


class SentTransforms:
    """Remembers what we sent of one transform, to tell it from what others send.

    Args:
        parent: Parent frame.
        child: Child frame; a frame has one parent, so any sample of the child counts.
    """

    def __init__(self, parent: str, child: str) -> None:
        """Start with nothing sent."""
        self.parent, self.child = parent, child
        self._sent: OrderedDict[tuple[int, tuple[float, float, float]], None] = OrderedDict()

    def note(self, stamp_ns: int, translation: tuple[float, float, float]) -> None:
        """Remember a sample of ours."""
        self._sent[stamp_ns, translation] = None
        if len(self._sent) > _KEPT:
            self._sent.popitem(last=False)

    def is_foreign(
        self, child: str, stamp_ns: int, translation: tuple[float, float, float]
    ) -> bool:
        """Return whether a sample is of our transform, but not from us."""
        return child == self.child and (stamp_ns, translation) not in self._sent
