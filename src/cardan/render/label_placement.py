"""Where the labels of a drawing stand, so that none lies on a part or on another label.

All positions are pixels of the page, y downward.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field

import numpy as np

from cardan.core.arrays import FloatArray

CHARACTER_WIDTH_TO_FONT_SIZE = 0.55
"""Mean width of a letter of the report's fonts; a little too wide rather than too narrow."""

STEP_ALONG_BAR_PX = 6.0


@dataclass(frozen=True, slots=True)
class Box:
    """An upright rectangle of the page."""

    left: float
    top: float
    right: float
    bottom: float

    def overlap(self, other: "Box") -> float:
        """Return the area that two rectangles share, px²."""
        wide = min(self.right, other.right) - max(self.left, other.left)
        high = min(self.bottom, other.bottom) - max(self.top, other.top)
        return max(wide, 0.0) * max(high, 0.0)

    def overhang(self, page: "Box") -> float:
        """Return the area of a rectangle that lies outside the page, px²."""
        own = (self.right - self.left) * (self.bottom - self.top)
        return own - self.overlap(page)


def text_box(
    x: float, y: float, lines: Sequence[str], *, font_size: float, anchor: str = "start"
) -> Box:
    """Return the rectangle of lines of text, the first with its base line at y."""
    wide = max(len(line) for line in lines) * font_size * CHARACTER_WIDTH_TO_FONT_SIZE
    left = x - {"start": 0.0, "middle": wide / 2, "end": wide}[anchor]
    bottom = y + 0.25 * font_size + (len(lines) - 1) * 1.25 * font_size
    return Box(left, y - 0.8 * font_size, left + wide, bottom)


def bar_boxes(start: FloatArray, end: FloatArray, thickness: float) -> Iterator[Box]:
    """Yield squares that cover a bar between two points (2,)."""
    count = int(np.hypot(*(end - start)) / STEP_ALONG_BAR_PX) + 2
    for x, y in start + (end - start) * np.linspace(0.0, 1.0, count)[:, None]:
        half = thickness / 2
        yield Box(float(x) - half, float(y) - half, float(x) + half, float(y) + half)


@dataclass
class LabelPlacer:
    """A page and what is taken of it."""

    page: Box
    taken: list[Box] = field(default_factory=list[Box])

    def place(self, candidates: Sequence[Box]) -> int:
        """Return the index of the first candidate that covers least, and take its place."""
        covered = [
            sum(box.overlap(other) for other in self.taken) + 10 * box.overhang(self.page)
            for box in candidates
        ]
        best = int(np.argmin(np.round(covered, 6)))
        self.taken.append(candidates[best])
        return best
