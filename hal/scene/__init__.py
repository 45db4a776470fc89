"""Geometry and textures of a world, for every renderer.

Surfaces, textures, ground tiles, shadows and the appearance of vehicles; the renderers
(:mod:`hal.raster`, pybullet's, and others by entry point) begin with them. Most of it needs numpy
and OpenCV, so nothing imports that before an image is wanted.
"""
