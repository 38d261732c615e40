"""Why a transform cannot be given; the kinds of tf2, each of which wants another answer."""


class TransformUnavailable(Exception):  # noqa: N818, the base says what it means
    """A transform cannot be given; the message names the frames, the stamp and what is there."""


class UnknownFrameError(TransformUnavailable, LookupError):
    """A frame was never heard of."""


class NotConnectedError(TransformUnavailable):
    """Both frames are known, no chain of transforms joins them."""


class FutureExtrapolationError(TransformUnavailable):
    """The stamp is newer than the newest sample of a frame: it may still come."""


class PastExtrapolationError(TransformUnavailable):
    """The stamp is older than the oldest sample of a frame."""


class TooEarlyError(PastExtrapolationError):
    """The stamp is older than all that the buffer keeps: it can no longer come."""
