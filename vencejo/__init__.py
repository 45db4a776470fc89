"""The ground that every package of Vencejo stands on."""

from vencejo.errors import Fault, UserError, VehicleError, Where
from vencejo.geometry import Point, distance, wrap
from vencejo.version import __version__

__all__ = [
    "Fault",
    "Point",
    "UserError",
    "VehicleError",
    "Where",
    "__version__",
    "distance",
    "wrap",
]
