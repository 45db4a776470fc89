"""The array types of images and geometry: one name per dtype."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Pixels = NDArray[np.uint8]
"""An image: (height, width) in grey, or (height, width, channels) as BGR or BGRA."""
Box = tuple[int, int, int, int]
"""Left, top, right and bottom of a part of an image, pixels; right and bottom are outside."""
Float64s = NDArray[np.float64]
Float32s = NDArray[np.float32]
Int64s = NDArray[np.int64]
Int32s = NDArray[np.int32]
Bools = NDArray[np.bool_]
