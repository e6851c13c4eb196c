"""Pixels within a page: an address that holds the whole picture."""

from base64 import b64encode
from io import BytesIO

import numpy as np
import numpy.typing as npt
from PIL import Image


def png_address(pixels: npt.NDArray[np.uint8]) -> str:
    """A PNG as an address that holds it: (rows, columns, channels), one channel or three."""
    is_grey = pixels.shape[2] == 1
    image = Image.fromarray(np.ascontiguousarray(pixels[:, :, 0] if is_grey else pixels))
    file = BytesIO()
    image.save(file, format="PNG", optimize=True)
    return f"data:image/png;base64,{b64encode(file.getvalue()).decode()}"
