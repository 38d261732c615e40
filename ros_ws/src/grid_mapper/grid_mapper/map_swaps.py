"""Whether a robot is looked for in a map that corrected ones have taken the place of."""

from __future__ import annotations

from floornav_common.grid import OccupancyMap
from grid_mapper.closing_mapper import ClosingMapper
from grid_mapper.layers import LayeredMapper
from grid_mapper.recovery import Recovery


class MapSwaps:
    """Watches for maps that were made anew: a place in the map of before is none in that of now.

    Args:
        mapper: Whose maps take the place of each other.
        recovery: Looks in the map as published last.

    Attributes:
        is_map_old: Whether the map published last is the one of before.
        is_search_old: Whether a search has begun in a map of before.
    """

    def __init__(self, mapper: LayeredMapper | ClosingMapper, recovery: Recovery) -> None:
        self._mapper, self._recovery = mapper, recovery
        self._num, self._newest = self._num_now, recovery.current_map
        self._before: OccupancyMap | None = None
        self.is_map_old = self.is_search_old = False

    def note(self) -> None:
        """Look at the maps; at every scan."""
        newest = self._recovery.current_map
        if self._num_now != self._num:
            self._num, self._before = self._num_now, self._newest
            self.is_search_old = self._recovery.is_active
            self.is_map_old = True
        self.is_map_old = self.is_map_old and newest is self._before
        self._newest = newest

    @property
    def _num_now(self) -> int:
        return self._mapper.num_swaps if isinstance(self._mapper, ClosingMapper) else 0
