"""The surface that pictures and films are drawn on, as pixels.

matplotlib's own has no types: they are written down here, once.
"""

from collections.abc import Iterable
from typing import Any

from matplotlib.artist import Artist
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from PIL import Image


class Canvas:
    """A figure's surface."""

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
        """Draw these over what was kept, in their order."""
        self._agg.restore_region(self._still)
        for artist in artists:
            artist.draw(self._agg.get_renderer())

    def image(self) -> Image.Image:
        """What is drawn."""
        return Image.frombuffer("RGBA", self.size, self._agg.buffer_rgba()).convert("RGB")
