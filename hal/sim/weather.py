"""The weather: the velocity of the air over place and time. World frame; metres, m/s, seconds."""

from __future__ import annotations

from math import cos, hypot, pi, sin

from hal.sim.gusts import GustTrain
from hal.sim.physics import Triple
from hal.sim.turbulence import Turbulence
from vencejo.seeds import generator
from worlds.world import Wind

_SLOWEST = 1.0
"""Least speed with which gusts travel, m/s."""


class Weather:
    """The air of a world: a mean wind, and gusts that travel with it.

    The mean wind is the same everywhere but for its profile over the height above z = 0; hills do
    not change it. A gust makes the whole profile stronger, and travels at the speed of the mean.
    """

    def __init__(self, wind: Wind, seed: int) -> None:
        bearing = wind.bearing * pi / 180
        self.wind = wind
        self.seed = seed
        self.east, self.north = -sin(bearing), -cos(bearing)
        """The direction in which the wind blows, a unit vector."""
        self._peak = 0.0
        if wind.gusts is not None:
            self._peak = wind.gusts.to - wind.speed
            self._gusts = GustTrain(wind.gusts, generator(seed, "weather", "gusts"))
        self._travel = max(_SLOWEST, wind.speed)

    def speed(self, position: Triple, time: float) -> float:
        """Speed of the wind, gusts included, at a place and a time."""
        x, y, z = position
        wind = self.wind
        speed = wind.speed
        if self._peak:
            way = x * self.east + y * self.north
            speed += self._peak * self._gusts.share(time - way / self._travel)
        return speed * wind.share_at(z)

    def of(self, vehicle: str) -> VehicleWeather:
        """The weather that a vehicle feels; its turbulence is its own."""
        return VehicleWeather(self, vehicle)


class VehicleWeather:
    """The weather as one vehicle feels it."""

    def __init__(self, weather: Weather, vehicle: str) -> None:
        self._weather = weather
        self._speed = weather.speed
        self._east, self._north = weather.east, weather.north
        strength = weather.wind.turbulence
        self._turbulence = (
            Turbulence(strength, generator(weather.seed, vehicle, "turbulence"))
            if strength
            else None
        )

    def wind(self, position: Triple, velocity: Triple, time: float) -> Triple:
        """Velocity of the air at the vehicle; to be asked once for each mission period.

        ``velocity`` is the vehicle's own over the ground: eddies pass it at its speed through the
        mean air.
        """
        east, north = self._east, self._north
        speed = self._speed(position, time)
        x, y = speed * east, speed * north
        if self._turbulence is None:
            return x, y, 0.0
        vx, vy, vz = velocity
        airspeed = hypot(vx - x, vy - y, vz)
        along, left, up = self._turbulence.next(position[2], airspeed)
        return x + along * east - left * north, y + along * north + left * east, up
