"""Scans of one frame: several echoes of a lidar, or several lidars, may publish on one topic."""

from collections import deque

RECENT = 16
"""Scans among which another frame is noticed."""


class FrameFilter:
    """Lets the scans of one frame pass, and refuses to choose where nobody said which."""

    def __init__(self, frame_id: str | None) -> None:
        """Begin with no scan.

        Args:
            frame_id: of the scans that are used; None: any, as long as it is one.
        """
        self._frame_id = frame_id
        self._recent: deque[str] = deque(maxlen=RECENT)

    def receive(self, frame_id: str) -> bool:
        """Note a scan's frame; returns whether the scan is to be used.

        Raises:
            ValueError: scans of several frames came lately, and the mapping does not say which are meant.
        """
        self._recent.append(frame_id)
        if self._frame_id is not None:
            return frame_id == self._frame_id
        frames = sorted(set(self._recent))
        if len(frames) > 1:
            listed = ", ".join(repr(frame) for frame in frames)
            raise ValueError(
                f"scans of {len(frames)} frames on one topic ({listed}): echoes or lidars that see different things; "
                "say in the mapping which are used, frame_id = ..."
            )
        return True

    @property
    def missing(self) -> bool:
        """Whether none of the latest scans is of the frame that is used."""
        return self._frame_id is not None and self._frame_id not in self._recent

    @property
    def others(self) -> list[str]:
        """Frames of the latest scans other than the one that is used."""
        return sorted(set(self._recent) - {self._frame_id})
