"""The weather: wind by place and time, gusts, turbulence and downwash."""

from __future__ import annotations

from itertools import pairwise
from math import cos, exp, hypot, log, pi, radians, sin, sqrt
from random import Random

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from hal.sim.downwash import downwash
from hal.sim.gusts import GustTrain
from hal.sim.model_files import load_model
from hal.sim.turbulence import Turbulence, scales_at
from hal.sim.weather import Weather
from hal.vehicle import PERIOD
from worlds.wind import TURBULENCE
from worlds.world import Gusts, Wind

ARDRONE2 = load_model("ardrone2")
ARDRONE2 = load_model("ardrone2")
STILL = (0.0, 0.0, 0.0)
GUST = Gusts(to=9.0, duration=4.0, every=20.0, at=(10.0,))
place = st.tuples(*[st.floats(-100, 100)] * 3)
FOOT = 0.3048


def air(wind: Wind, position=STILL, time=0.0, seed=0):  # type: ignore[no-untyped-def]
    return Weather(wind, seed).of("drone").wind(position, STILL, time)


# Mean wind.


@pytest.mark.parametrize(
    ("bearing", "blows"),
    [(0.0, (0, -5, 0)), (90.0, (-5, 0, 0)), (180.0, (0, 5, 0)), (270.0, (5, 0, 0))],
)
def test_the_bearing_is_where_it_comes_from(bearing, blows) -> None:  # type: ignore[no-untyped-def]
    assert air(Wind(5.0, bearing)) == pytest.approx(blows)


@given(place, st.floats(0, 1000))
def test_a_mean_wind_is_the_same_everywhere_and_always(position, time) -> None:  # type: ignore[no-untyped-def]
    assert air(Wind(5.0, 30.0), position, time) == air(Wind(5.0, 30.0))


@given(st.floats(-1.0, 500.0))
def test_over_rough_ground_it_follows_the_logarithmic_law(height: float) -> None:
    wind = Wind(5.0, 270.0, height=8.0, roughness=0.1)
    expected = 5.0 * log(height / 0.1) / log(80.0) if height > 0.1 else 0.0
    assert air(wind, (3.0, 4.0, height)) == pytest.approx((expected, 0.0, 0.0))


# Gusts.


def test_a_gust_is_a_cosine_from_the_mean_to_its_peak_and_back() -> None:
    wind = Wind(3.0, 270.0, gusts=GUST)
    times = np.arange(0.0, 20.0, 0.01)
    weather = Weather(wind, 0).of("drone")
    east = [weather.wind(STILL, STILL, float(time))[0] for time in times]
    inside = (times >= 10.0) & (times <= 14.0)
    expected = np.where(inside, 3.0 + 6.0 * (1 - np.cos(2 * pi * (times - 10.0) / 4.0)) / 2, 3.0)
    assert east == pytest.approx(expected, abs=1e-9)
    assert max(east) == pytest.approx(9.0)


@given(place, st.floats(0, 30))
def test_a_gust_travels_with_the_mean_wind(position, time) -> None:  # type: ignore[no-untyped-def]
    wind = Wind(4.0, 200.0, gusts=GUST)
    direction = -sin(radians(200.0)), -cos(radians(200.0))
    way = position[0] * direction[0] + position[1] * direction[1]
    here = air(wind, position, time)
    assert here == pytest.approx(air(wind, STILL, time - way / 4.0), abs=1e-9)


def test_without_a_mean_wind_gusts_travel_all_the_same() -> None:
    wind = Wind(0.0, 270.0, gusts=GUST)
    assert air(wind, (7.0, 0.0, 1.0), 19.0)[0] == pytest.approx(9.0)


def test_places_down_the_wind_have_random_gusts_from_the_beginning() -> None:
    wind = Wind(3.0, 270.0, gusts=Gusts(8.0, 3.0, 15.0))
    weather = Weather(wind, 0).of("drone")
    assert max(weather.wind((600.0, 0.0, 5.0), STILL, time / 4)[0] for time in range(200)) > 6.0


def test_over_rough_ground_a_gust_is_weaker_below_by_the_same_law() -> None:
    wind = Wind(3.0, 270.0, roughness=0.1, gusts=GUST)
    assert air(wind, (0.0, 0.0, 1.0), 12.0)[0] == pytest.approx(9.0 * log(10) / log(100))


def test_random_gusts_come_as_often_as_said_and_never_overlap() -> None:
    train = GustTrain(Gusts(8.0, 3.0, 15.0), Random(1))
    times = np.arange(0.0, 30_000.0, 0.05)
    shares = np.array([train.share(float(time)) for time in times])
    begins = times[1:][(shares[:-1] == 0.0) & (shares[1:] > 0.0)]
    assert 30_000 / len(begins) == pytest.approx(15.0, rel=0.1)
    assert all(later - earlier > 3.0 - 0.1 for earlier, later in pairwise(begins))
    assert shares.mean() == pytest.approx(3.0 / 2 / 15.0, rel=0.1)


def test_gusts_depend_on_the_seed_and_not_on_the_order_in_which_they_are_asked_for() -> None:
    gusts = Gusts(8.0, 3.0, 15.0)
    times = [float(time) for time in range(200)]
    one, same, other = (GustTrain(gusts, Random(seed)) for seed in (1, 1, 2))
    forwards = [one.share(time) for time in times]
    assert [same.share(time) for time in reversed(times)] == forwards[::-1]
    assert [other.share(time) for time in times] != forwards


def test_all_vehicles_meet_the_same_gusts() -> None:
    weather = Weather(Wind(3.0, 0.0, gusts=Gusts(8.0, 3.0, 15.0)), 5)
    a, b = weather.of("a"), weather.of("b")
    for time in range(100):
        assert a.wind(STILL, STILL, time) == b.wind(STILL, STILL, time)


# Turbulence.


@pytest.fixture(scope="module")
def samples() -> np.ndarray:
    """Two hours and more at 10 m height and 5 m/s, in a wind of 7.7 m/s."""
    turbulence = Turbulence(7.7, Random(3))
    return np.array([turbulence.next(10.0, 5.0) for _ in range(400_000)])


def test_the_scales_are_those_of_the_specification() -> None:
    length, sigma, length_up, sigma_up = scales_at(100 * FOOT, TURBULENCE["moderate"])
    shear = 0.177 + 0.000823 * 100
    assert length_up == pytest.approx(100 * FOOT)
    assert length == pytest.approx(100 * FOOT / shear**1.2)
    assert sigma_up == pytest.approx(3.0 * 1852 / 3600)
    assert sigma == pytest.approx(sigma_up / shear**0.4)
    assert scales_at(5000.0, 1.0) == scales_at(1000 * FOOT, 1.0)
    assert scales_at(1000 * FOOT, 1.0).sigma == pytest.approx(scales_at(1000 * FOOT, 1.0).sigma_up)
    assert scales_at(0.0, 1.0) == scales_at(10 * FOOT, 1.0)


def test_each_axis_has_the_deviation_of_the_specification(samples: np.ndarray) -> None:
    scales = scales_at(10.0, 7.7)
    expected = (scales.sigma, scales.sigma, scales.sigma_up)
    assert samples.std(axis=0) == pytest.approx(expected, rel=0.1)
    assert np.abs(samples.mean(axis=0)) == pytest.approx(0.0, abs=0.15)
    assert np.corrcoef(samples.T) == pytest.approx(np.eye(3), abs=0.06)


def test_each_axis_has_the_spectrum_of_the_specification(samples: np.ndarray) -> None:
    """By its autocorrelation: exp(−r) along the path, (1 − r/2) exp(−r) across it, r = V·t/L."""
    scales = scales_at(10.0, 7.7)
    lengths = (scales.length, scales.length, scales.length_up)
    for axis, length in enumerate(lengths):
        values = samples[:, axis] - samples[:, axis].mean()
        for share in (0.25, 0.5, 1.0, 2.0):
            lag = round(share * length / (5.0 * PERIOD))
            r = lag * 5.0 * PERIOD / length
            found = (values[:-lag] * values[lag:]).mean() / values.var()
            expected = exp(-r) if axis == 0 else (1 - r / 2) * exp(-r)
            assert found == pytest.approx(expected, abs=0.07)


@pytest.mark.parametrize("speed", [100.0, 400.0])
def test_its_filters_are_exact_however_far_a_period_takes_the_vehicle(speed: float) -> None:
    """So fast, low above ground, samples have little in common, and so measure sharply."""
    turbulence = Turbulence(7.7, Random(4))
    samples = np.array([turbulence.next(3.0, speed) for _ in range(60_000)])
    scales = scales_at(3.0, 7.7)
    expected = (scales.sigma, scales.sigma, scales.sigma_up)
    assert samples.std(axis=0) == pytest.approx(expected, rel=0.015)
    along, across, up = ((samples[1:] * samples[:-1]).mean(axis=0) / samples.var(axis=0)).tolist()
    r, r_up = speed * PERIOD / scales.length, speed * PERIOD / scales.length_up
    assert along == pytest.approx(exp(-r), abs=0.02)
    assert across == pytest.approx((1 - r / 2) * exp(-r), abs=0.02)
    assert up == pytest.approx((1 - r_up / 2) * exp(-r_up), abs=0.02)


def test_it_has_its_deviation_from_the_first_moment_on() -> None:
    first = np.array([Turbulence(7.7, Random(k)).next(10.0, 5.0) for k in range(4000)])
    scales = scales_at(10.0, 7.7)
    expected = (scales.sigma, scales.sigma, scales.sigma_up)
    assert first.std(axis=0) == pytest.approx(expected, rel=0.1)


@settings(max_examples=50, deadline=None)
@given(st.floats(-10, 1e4), st.floats(0, 100))
def test_at_any_height_and_speed_it_is_finite(height: float, speed: float) -> None:
    turbulence = Turbulence(20.0, Random(0))
    values = np.array([turbulence.next(height, speed) for _ in range(100)])
    assert np.isfinite(values).all()
    assert np.abs(values).max() < 8 * scales_at(height, 20.0).sigma


def test_it_is_turned_into_the_wind() -> None:
    """The noise along the path points along the wind, from whichever side that comes."""
    mean = Wind(5.0, 250.0)
    weather = Weather(Wind(5.0, 250.0, turbulence=5.0), 1).of("drone")
    moved = np.array([weather.wind((0, 0, 10.0), STILL, 0.0) for _ in range(100)])
    turbulence = Weather(Wind(5.0, 270.0, turbulence=5.0), 1).of("drone")
    east = np.array([turbulence.wind((0, 0, 10.0), STILL, 0.0) for _ in range(100)]) - (5, 0, 0)
    angle = radians(20.0)
    turned = east @ np.array([[cos(angle), sin(angle), 0], [-sin(angle), cos(angle), 0], [0, 0, 1]])
    assert moved - air(mean) == pytest.approx(turned, abs=1e-9)


def test_each_vehicle_feels_its_own_and_one_more_changes_no_other() -> None:
    wind = Wind(3.0, 0.0, turbulence=5.0)

    def flown(names: list[str], seed: int = 0) -> dict[str, list[tuple[float, float, float]]]:
        weather = Weather(wind, seed)
        vehicles = {name: weather.of(name) for name in names}
        found: dict[str, list[tuple[float, float, float]]] = {name: [] for name in names}
        for period in range(100):
            for name, vehicle in vehicles.items():
                found[name].append(vehicle.wind((0, 0, 5.0), STILL, period * PERIOD))
        return found

    two, three = flown(["a", "b"]), flown(["c", "a", "b"])
    assert two["a"] != two["b"]
    assert (three["a"], three["b"]) == (two["a"], two["b"])
    assert flown(["a"], seed=1)["a"] != two["a"]
    assert flown(["a"])["a"] == two["a"]


# Downwash.


@pytest.mark.parametrize("below", [0.2, 1.0, 5.0])
def test_the_jet_carries_the_momentum_of_the_thrust_at_every_level(below: float) -> None:
    r = np.linspace(0.0, 3.0, 3001)
    speeds = [downwash(ARDRONE2.rotors, 4.0, (float(x), 0.0, -below)) for x in r]
    momentum = 1.225 * np.trapezoid(2 * pi * r * np.square(speeds), r)
    assert momentum == pytest.approx(4.0, rel=0.01)


def test_right_below_the_rotors_the_air_has_twice_the_induced_velocity() -> None:
    induced = sqrt(4.0 / (2 * 1.225 * ARDRONE2.rotors.area))
    assert downwash(ARDRONE2.rotors, 4.0, (0.0, 0.0, -1e-6)) == pytest.approx(2 * induced, rel=1e-4)


@given(st.floats(-3, 3), st.floats(-3, 3), st.floats(-20, 5))
def test_it_blows_down_below_and_fades_outwards_and_downwards(x: float, y: float, z: float) -> None:
    rotors = ARDRONE2.rotors
    speed = downwash(rotors, 4.0, (x, y, z))
    assert speed >= 0.0
    assert (speed == 0.0) if z >= 0.0 else speed <= downwash(rotors, 4.0, (0.0, 0.0, z))
    assert speed == pytest.approx(downwash(rotors, 4.0, (hypot(x, y), 0.0, z)), abs=0.05)
    assert downwash(rotors, 0.0, (x, y, z)) == 0.0
    if z < 0:
        assert downwash(rotors, 4.0, (0, 0, z - 1)) < downwash(rotors, 4.0, (0, 0, z))
