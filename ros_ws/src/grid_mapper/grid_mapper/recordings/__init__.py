"""Recordings of many formats as one stream of events, in lockstep and without ROS."""

from grid_mapper.recordings.events import (
    Counts,
    Event,
    RangeEvent,
    Recording,
    RecordingError,
    RecordingOptions,
    ScanEvent,
)
from grid_mapper.recordings.formats import open_recording

__all__ = [
    "Counts",
    "Event",
    "RangeEvent",
    "Recording",
    "RecordingError",
    "RecordingOptions",
    "ScanEvent",
    "open_recording",
]
