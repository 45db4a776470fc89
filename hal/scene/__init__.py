"""What every renderer needs of a world: surfaces, textures, ground tiles, shadows, appearances.

Nothing here draws a picture: :mod:`hal.raster` and pybullet's renderers do, and both start from
these modules. They need numpy and OpenCV, so nothing imports them before a picture is wanted.
"""
