"""Dryden turbulence near the ground, as a vehicle that flies through it feels it.

The low-altitude model of MIL-F-8785C (3.7), in Dryden's form. Frozen eddies pass the vehicle at its
speed through the air; the velocity of the air is noise behind the filters

    H_u(s) = σ_u √(2τ_u) / (1 + τ_u s)
    H_v(s) = σ_v √τ_v (1 + √3 τ_v s) / (1 + τ_v s)²        (w alike), τ = L / V.
"""

from __future__ import annotations

from math import exp, sqrt
from random import Random
from typing import NamedTuple

from hal.vehicle import PERIOD

_FOOT = 0.3048
_LOWEST, _HIGHEST = 10.0, 1000.0
"""Heights between which the model holds, feet; beyond them it is taken as there."""
_SLOWEST = 1.0
"""Least speed at which eddies pass, m/s: in still air they would never change."""
_SQRT_3 = sqrt(3.0)
_RECENT = 0.02
"""Relative change of height or airspeed from which the filters are computed anew."""


class Scales(NamedTuple):
    """The turbulence at a height: along the wind (and, alike, across it) and upwards."""

    length: float
    """Of the eddies along the wind and across it, metres."""
    sigma: float
    """Standard deviation along the wind and across it, m/s."""
    length_up: float
    sigma_up: float


def scales_at(height: float, wind: float) -> Scales:
    """The scales at a height above ground (m), for a ``wind`` 20 feet above it (m/s).

    L_w = h, L_u = L_v = h / (0.177 + 0.000823 h)^1.2, σ_w = 0.1 W20, and
    σ_u = σ_v = σ_w / (0.177 + 0.000823 h)^0.4, with h in feet (MIL-F-8785C, 3.7).
    """
    feet = min(_HIGHEST, max(_LOWEST, height / _FOOT))
    shear = 0.177 + 0.000823 * feet
    up = 0.1 * wind
    return Scales(feet / shear**1.2 * _FOOT, up / shear**0.4, feet * _FOOT, up)


class _Across:
    """The noise of one axis across the path: H(s) in normal form, discretised exactly.

    H = σ√τ (√3 − (√3 − 1)/(1 + τs)) / (1 + τs): with time counted in τ and unit white noise ξ,
    x' = −x + ξ and y' = x − y give the velocity σ (√3 x − (√3 − 1) y), of variance σ².
    """

    def __init__(self, random: Random) -> None:
        self._gauss = random.gauss
        x = self._gauss(0.0, sqrt(0.5))
        # The stationary covariance: ⟨x²⟩ = 1/2, ⟨xy⟩ = ⟨y²⟩ = 1/4.
        self._x, self._y = x, x / 2 + self._gauss(0.0, sqrt(0.125))
        self._decay = self._step = self._x_noise = self._y_noise = self._own = 0.0

    def set_step(self, step: float) -> None:
        """Set the length of a period in units of τ."""
        decay = exp(-step)
        square = decay * decay
        xx = (1.0 - square) / 2.0
        xy = (1.0 - square * (1.0 + 2.0 * step)) / 4.0
        yy = (1.0 - square * (1.0 + 2.0 * step + 2.0 * step * step)) / 4.0
        self._decay, self._step = decay, step
        self._x_noise = sqrt(xx)
        self._y_noise = xy / self._x_noise
        self._own = sqrt(max(0.0, yy - xy * xy / xx))

    def next(self) -> float:
        """The velocity of the next period, for σ = 1."""
        shared, own = self._gauss(0.0, 1.0), self._gauss(0.0, 1.0)
        x, decay = self._x, self._decay
        self._x = decay * x + self._x_noise * shared
        self._y = decay * (self._y + self._step * x) + self._y_noise * shared + self._own * own
        return _SQRT_3 * self._x - (_SQRT_3 - 1.0) * self._y


class Turbulence:
    """The turbulence that one vehicle feels."""

    def __init__(self, wind: float, random: Random) -> None:
        """``wind`` is the speed 20 feet above ground that makes it, m/s."""
        self._wind = wind
        self._gauss = random.gauss
        self._along = random.gauss(0.0, 1.0)
        self._across, self._up = _Across(random), _Across(random)
        self._height = self._speed = 0.0
        """Those for which the filters were computed."""
        self._scales = scales_at(0.0, wind)
        self._decay = self._noise = 0.0

    def next(self, height: float, speed: float) -> tuple[float, float, float]:
        """The velocity of the air in the next period: along the wind, to its left, and up, m/s.

        ``height`` is that above ground, metres; ``speed`` that through the mean air, m/s.
        """
        speed = max(_SLOWEST, speed)
        if (
            abs(speed - self._speed) > _RECENT * self._speed
            or abs(height - self._height) > _RECENT * self._height
        ):
            self._adapt(height, speed)
        self._along = self._decay * self._along + self._noise * self._gauss(0.0, 1.0)
        _, sigma, _, sigma_up = self._scales
        return sigma * self._along, sigma * self._across.next(), sigma_up * self._up.next()

    def _adapt(self, height: float, speed: float) -> None:
        self._height, self._speed = height, speed
        self._scales = scales = scales_at(height, self._wind)
        passed = speed * PERIOD
        self._decay = exp(-passed / scales.length)
        self._noise = sqrt(1.0 - self._decay * self._decay)
        self._across.set_step(passed / scales.length)
        self._up.set_step(passed / scales.length_up)
