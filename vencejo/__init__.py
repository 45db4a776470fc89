"""The common ground of all packages: errors, units, geometry, YAML with positions, seeds."""

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
