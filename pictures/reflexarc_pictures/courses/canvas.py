"""The pixels of a figure, as pictures and films need them.

matplotlib's canvas has no type annotations; this wrapper has.
"""

from collections.abc import Iterable
from typing import Any

from matplotlib.artist import Artist
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from PIL import Image


class Canvas:
    """Draws a figure into memory."""

    def __init__(self, figure: Figure) -> None:
        self._agg: Any = FigureCanvasAgg(figure)
        self._figure = figure
        self._still: Any = None

    @property
    def size(self) -> tuple[int, int]:
        """Width and height in pixels."""
        width, height = self._agg.get_width_height()
        return width, height

    def draw(self) -> None:
        """Draw everything that is not animated, and keep it."""
        self._agg.draw()
        self._still = self._agg.copy_from_bbox(self._figure.bbox)

    def draw_over(self, artists: Iterable[Artist]) -> None:
        """Draw artists over what `draw` kept, in their order."""
        self._agg.restore_region(self._still)
        for artist in artists:
            artist.draw(self._agg.get_renderer())

    def image(self) -> Image.Image:
        """The pixels now."""
        return Image.frombuffer("RGBA", self.size, self._agg.buffer_rgba()).convert("RGB")
