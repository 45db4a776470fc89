"""The renderer ``raster``: images from numpy and OpenCV alone."""

from hal.raster.renderer import Raster

__all__ = ["Raster"]
