"""Select the scans of one frame, because several echoes of a lidar, or several lidars, may publish on one topic."""

from collections import deque

RECENT = 16
"""Number of latest scans whose frames are remembered."""


class FrameFilter:
    """Filter for the scans of one frame; without a stated frame, it refuses topics on which frames are mixed."""

    def __init__(self, frame_id: str | None) -> None:
        """Start with no scan.

        Args:
            frame_id: frame of the scans that are used; None: any frame, as long as all scans have the same.
        """
        self._frame_id = frame_id
        self._recent: deque[str] = deque(maxlen=RECENT)

    def receive(self, frame_id: str) -> bool:
        """Return True if a scan of this frame is to be used.

        Raises:
            ValueError: the latest scans have several frames, and the mapping does not state which one to use.
        """
        self._recent.append(frame_id)
        if self._frame_id is not None:
            return frame_id == self._frame_id
        frames = sorted(set(self._recent))
        if len(frames) > 1:
            listed = ", ".join(repr(frame) for frame in frames)
            raise ValueError(
                f"scans of {len(frames)} frames on one topic ({listed}) are different echoes or lidars: state in the "
                "mapping which of them to use, frame_id = ..."
            )
        return True

    @property
    def missing(self) -> bool:
        """True if none of the latest scans has the frame that is used."""
        return self._frame_id is not None and self._frame_id not in self._recent

    @property
    def others(self) -> list[str]:
        """Frames of the latest scans, without the one that is used."""
        return sorted(set(self._recent) - {self._frame_id})
