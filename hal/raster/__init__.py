"""The renderer ``raster``: pictures by numpy and OpenCV alone."""

from hal.raster.renderer import Raster

__all__ = ["Raster"]
