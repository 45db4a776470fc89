"""Vehicles: the contract that missions fly on, and its backends found by name."""

from hal.backends import backend_capabilities, backend_names, flight_model, open_backend
from hal.base import BaseSession, BaseVehicle
from hal.flight_model import FlightModel
from hal.lights import Lights
from hal.limits import Limits
from hal.orders import Order, Orders
from hal.vehicle import (
    ACCEPTED,
    PERIOD,
    VALIDITY,
    Answer,
    Attitude,
    Camera,
    Frame,
    Hold,
    Intrinsics,
    Observation,
    Options,
    Position,
    Reading,
    Sensor,
    Session,
    Setpoint,
    Unavailable,
    Vehicle,
    VehicleEvent,
    VehicleSpec,
    Velocity,
    VisionPose,
)

__all__ = [
    "ACCEPTED",
    "PERIOD",
    "VALIDITY",
    "Answer",
    "Attitude",
    "BaseSession",
    "BaseVehicle",
    "Camera",
    "FlightModel",
    "Frame",
    "Hold",
    "Intrinsics",
    "Lights",
    "Limits",
    "Observation",
    "Options",
    "Order",
    "Orders",
    "Position",
    "Reading",
    "Sensor",
    "Session",
    "Setpoint",
    "Unavailable",
    "Vehicle",
    "VehicleEvent",
    "VehicleSpec",
    "Velocity",
    "VisionPose",
    "backend_capabilities",
    "backend_names",
    "flight_model",
    "open_backend",
]
