"""A window that shows one frame after another, by Tk, which comes with Python.

Where there is no display, or a Python without Tk, nothing is shown, which is said once: a training
run on a server goes on. So it does where somebody closes the window.
"""

import logging
import time
from typing import Any

from reflexarc_sim_bridge.environments.raster import Pixels

_log = logging.getLogger(__name__)


class Window:
    """Opens at the first frame.

    Args:
        title: what stands above it.
        rate_hz: frames a second, at most; `show` waits.
    """

    def __init__(self, title: str, rate_hz: float) -> None:
        self._title, self._period_s = title, 1.0 / rate_hz
        self._root: Any = None
        self._is_closed = False
        self._next_s = 0.0

    def __reduce__(self) -> tuple[type["Window"], tuple[str, float]]:
        """A copy opens a window of its own."""
        return Window, (self._title, 1.0 / self._period_s)

    def show(self, frame: Pixels) -> None:
        """Show a frame, when its time has come."""
        if self._root is None and not self._is_closed:
            self._open()
        if self._root is None:
            return
        time.sleep(max(0.0, self._next_s - time.monotonic()))
        self._next_s = time.monotonic() + self._period_s
        import tkinter

        try:
            self._image.configure(data=as_ppm(frame), format="PPM")
            self._root.update()
        except tkinter.TclError:  # the display went away, or it was closed meanwhile
            self.close()

    def close(self) -> None:
        """Close it, for good."""
        root, self._root, self._is_closed = self._root, None, True
        if root is not None:
            import contextlib
            import tkinter

            with contextlib.suppress(tkinter.TclError):
                root.destroy()

    def _open(self) -> None:
        try:
            import tkinter
        except ImportError as error:
            self._do_without(error)
            return
        try:
            self._root = tkinter.Tk()
        except tkinter.TclError as error:
            self._do_without(error)
            return
        self._root.title(self._title)
        self._root.protocol("WM_DELETE_WINDOW", self.close)
        self._image = tkinter.PhotoImage(master=self._root)
        tkinter.Label(self._root, image=self._image, borderwidth=0).pack()

    def _do_without(self, error: Exception) -> None:
        self._is_closed = True
        _log.warning("render_mode='human': nothing is shown (%s)", str(error) or "no Tk")


def as_ppm(frame: Pixels) -> bytes:
    """The pixels as a file of the format PPM."""
    height, width, _ = frame.shape
    return b"P6 %d %d 255\n" % (width, height) + frame.tobytes()
