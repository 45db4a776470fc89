"""Perception: pure functions on images, usable without a vehicle.

Images are BGR, ``uint8``, (height, width, 3); what is measured in them is in pixels, and what is
measured in the world in the axes of the frame's pose. Nothing here knows behaviours.
"""

from behaviors.perception.blobs import Blob, blobs
from behaviors.perception.color import ColorRange, mask, range_of, read_color
from behaviors.perception.fiducials import Detections, Fiducial, FiducialDetector
from behaviors.perception.marker_pose import MarkerPose, marker_pose
from behaviors.perception.projection import (
    bearing,
    directions,
    ground_point,
    ground_points,
    pixels_of,
)
from behaviors.perception.target_filter import TargetFilter

__all__ = [
    "Blob",
    "ColorRange",
    "Detections",
    "Fiducial",
    "FiducialDetector",
    "MarkerPose",
    "TargetFilter",
    "bearing",
    "blobs",
    "directions",
    "ground_point",
    "ground_points",
    "marker_pose",
    "mask",
    "pixels_of",
    "range_of",
    "read_color",
]
