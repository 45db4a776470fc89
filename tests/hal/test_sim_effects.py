"""The effects of the simulator against closed formulas, written independently of its code."""

from __future__ import annotations

from dataclasses import replace
from itertools import pairwise
from math import atan, exp, pi, sqrt, tan

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from hal.engines import open_engine
from hal.sim import SimSession
from hal.sim.effects import IDEAL, REAL, Effects, plain_effects, read_effects
from hal.sim.model_files import load_model
from hal.sim.motion import Motion, axes_of
from hal.sim.physics import BodyState, Triple
from hal.sim.rotors import RotorDrive
from hal.vehicle import (
    Attitude,
    Hold,
    Limits,
    Observation,
    Options,
    Position,
    VehicleSpec,
    Velocity,
)
from tests.hal.engines import ENGINES
from tests.hal.flying import LONG, decided, finish, only, session_of, take_off, told, wait
from tests.hal.scenes import thing_of, world_of
from vencejo.errors import UserError
from vencejo.geometry import Point, roll_pitch_of, turned
from worlds.things import Cuboid
from worlds.world import Start, World

MODEL = load_model("ardrone2")
G, RHO = 9.80665, 1.225
WEIGHT = MODEL.mass * G


def sim_session(
    *vehicles: VehicleSpec, world: World | None = None, **settings: object
) -> SimSession:
    """Vehicles of which more is asked than their names."""
    engine = settings.get("engine")
    assert engine is None or isinstance(engine, str)
    return SimSession(
        Options(vehicles, settings=settings), world or world_of(), open_engine(engine)
    )


def norm(vector: tuple[float, ...]) -> float:
    return sqrt(sum(value * value for value in vector))


def momentum_of(state: BodyState, inertia: Triple) -> Triple:
    """The angular momentum, N·m·s, world frame."""
    x, y, z = (i * w for i, w in zip(inertia, state[3], strict=True))
    return turned((x, y, z), state[1])


def energy_of(state: BodyState, inertia: Triple) -> float:
    """That of the turning, joules."""
    return sum(i * w * w for i, w in zip(inertia, state[3], strict=True)) / 2


def drag(speed: float) -> float:
    """Newtons, at a level speed: what tan(tilt) times the weight has to make up for."""
    return RHO / 2 * MODEL.drag.area * speed**2 + MODEL.drag.rotors * speed


def tilt_in(session: SimSession, speed: float) -> tuple[float, float]:
    """The tilt (rad) and the speed (m/s) at which a vehicle flies in the end."""
    take_off(session, 40)
    vehicle = only(session)
    vehicle.command(Velocity(x=speed), LONG)
    seen = wait(session, 12)[-1]
    roll, pitch = roll_pitch_of(seen.attitude)
    return sqrt(roll**2 + pitch**2), seen.velocity.x


@pytest.mark.parametrize("speed", [1.0, 3.0, 5.0])
def test_a_steady_speed_needs_the_tilt_that_the_drag_gives(speed: float) -> None:
    with session_of(world_of()) as session:
        tilt, reached = tilt_in(session, speed)
    assert reached == pytest.approx(speed, rel=0.005)
    assert tilt == pytest.approx(atan(drag(speed) / WEIGHT), rel=0.02)


def test_without_drag_a_steady_speed_needs_no_tilt() -> None:
    with session_of(world_of(), physics="real,-drag") as session:
        tilt, reached = tilt_in(session, 5.0)
    assert (tilt, reached) == (pytest.approx(0.0, abs=1e-3), pytest.approx(5.0, rel=1e-3))


def test_the_top_speed_ends_where_drag_meets_the_largest_tilt() -> None:
    low, high = 0.0, 40.0
    while high - low > 1e-6:
        middle = (low + high) / 2
        low, high = (middle, high) if drag(middle) < WEIGHT * tan(0.3) else (low, middle)
    with session_of(world_of()) as session:
        take_off(session, 40)
        vehicle = only(session)
        vehicle.configure(Limits(max_speed=40.0, max_tilt=0.3))
        vehicle.command(Velocity(x=40.0), LONG)
        assert wait(session, 25)[-1].velocity.x == pytest.approx(low, rel=0.01)


def test_what_falls_ends_at_its_terminal_speed() -> None:
    """Upright and with its motors off: the body's drag alone."""
    terminal = sqrt(2 * WEIGHT / (RHO * MODEL.drag.area))
    with session_of(world_of(start=Point(0, 0, 0))) as session:
        take_off(session, 90)
        only(session).emergency_stop()
        seen = wait(session, 3)[-1]
        # v = vt·tanh(g·t/vt) after t seconds.
        fall = 3 * G / terminal
        expected = terminal * (1 - exp(-2 * fall)) / (1 + exp(-2 * fall))
        assert -seen.velocity.z == pytest.approx(expected, rel=0.02)


def power(climb: float) -> float:
    """Electrical power, W, of a steady climb in still air, by momentum theory."""
    rotors = MODEL.rotors
    hover = sqrt(WEIGHT / (2 * RHO * 4 * pi * rotors.radius**2))
    down = RHO / 2 * MODEL.drag.area * climb * abs(climb)
    thrust = WEIGHT + down
    half = climb / 2
    through = half + sqrt(half**2 + hover**2 * thrust / WEIGHT)
    return MODEL.battery.standby + thrust * through / rotors.efficiency


@pytest.mark.parametrize("climb", [2.0, 1.0, 0.0, -1.0, -2.0])
def test_climbing_takes_more_power_and_sinking_less(climb: float) -> None:
    with session_of(world_of()) as session:
        vehicle = take_off(session, 40)
        vehicle.command(Velocity(z=climb), LONG)
        begin = wait(session, 2)[-1]
        end = wait(session, 8)[-1]
    pack = MODEL.battery
    voltage = pack.empty + (pack.full - pack.empty) * (begin.battery + end.battery) / 2
    drawn = power(climb)
    current = (voltage - sqrt(voltage**2 - 4 * pack.resistance * drawn)) / (2 * pack.resistance)
    assert (begin.battery - end.battery) * pack.energy == pytest.approx(
        8 * current * voltage, rel=0.01
    )
    if climb == 2.0:
        assert (drawn - 5) / (power(0.0) - 5) == pytest.approx(1.3, abs=0.03)
    if climb == -2.0:
        assert (drawn - 5) / (power(0.0) - 5) == pytest.approx(0.77, abs=0.03)


def test_the_time_to_empty_in_hover() -> None:
    """The charge falls by current times voltage over the energy: summed up in small parts."""
    pack, drawn, seconds = MODEL.battery, power(0.0), 0.0
    for part in range(1000):
        voltage = pack.empty + (pack.full - pack.empty) * (part + 0.5) / 1000
        current = (voltage - sqrt(voltage**2 - 4 * pack.resistance * drawn)) / (2 * pack.resistance)
        seconds += pack.energy / 1000 / (current * voltage)
    with session_of(world_of()) as session:
        vehicle = take_off(session, 3)
        began = vehicle.observe()
        vehicle.command(Hold(), 1e9)
        while vehicle.observe().armed:
            wait(session, 1)
        flown = vehicle.observe().time - began.time
    assert flown == pytest.approx(seconds * began.battery, rel=0.01)
    assert seconds == pytest.approx(MODEL.endurance, rel=1e-3)


def test_the_ground_carries() -> None:
    """Hovering low over a box takes less thrust: 1 - (R/4h)² of the weight."""

    def drained(physics: str) -> float:
        with session_of(world_of(), physics=physics) as session:
            vehicle = take_off(session, 1.0)
            wait(session, 4, Position(Point(0, 0, 0.05)))
            before = vehicle.observe().battery
            return before - wait(session, 10, Position(Point(0, 0, 0.05)))[-1].battery

    height = 0.05 + MODEL.height
    less = 1 - (MODEL.rotors.radius / (4 * height)) ** 2
    standby = MODEL.battery.standby / MODEL.hover_power
    # Power goes with the thrust to the power of 3/2.
    expected = standby + (1 - standby) * less**1.5
    assert drained("real") / drained("real,-ground_effect") == pytest.approx(expected, rel=0.01)


def test_a_low_battery_gives_less_thrust() -> None:
    pack = MODEL.battery
    with session_of(world_of()) as session:
        vehicle = take_off(session, 3)
        vehicle.command(Attitude(thrust=1.0), LONG)
        seen = wait(session, 0.5)
        climbs = [b.velocity.z - a.velocity.z for a, b in pairwise(seen)]
        sagged = pack.voltage(seen[-1].battery) - pack.current(150, 1.0) * pack.resistance
        most = MODEL.max_thrust * (sagged / pack.full) ** 2
        assert climbs[-1] * 40 < (most / WEIGHT - 1) * G * 1.15
        assert climbs[-1] * 40 < (MODEL.max_thrust / WEIGHT - 1) * G * 0.95


@pytest.mark.parametrize("model", ["ardrone2", "crazyflie"])
def test_a_low_battery_takes_off_and_lands_in_wind(model: str) -> None:
    """Its thrust hardly carries it at its largest tilt: it leans less, and drifts."""
    world = replace(world_of(), battery=0.05)
    with sim_session(VehicleSpec("drone", model), world=world, wind="6 m/s@270 deg") as session:
        vehicle = only(session)
        finish(session, vehicle.takeoff(1.0), 6)
        finish(session, vehicle.land(), 6)
        assert vehicle.observe().mode == "landed" and not vehicle.observe().health


# Rotors.

WRENCHES = st.tuples(st.floats(-5, 20), st.floats(-2, 2), st.floats(-2, 2), st.floats(-0.5, 0.5))


@settings(deadline=None)
@given(st.lists(WRENCHES, min_size=1, max_size=10))
def test_no_rotor_gives_more_or_less_than_it_can(wanted: list[tuple[float, ...]]) -> None:
    drive, rotors = RotorDrive(MODEL), MODEL.rotors
    lever = rotors.arm / sqrt(2)
    for wrench in wanted:
        thrust, x, y, z = drive.step(wrench)  # type: ignore[arg-type]
        roll, pitch, yaw = x / lever / 4, y / lever / 4, z / rotors.drag_ratio / 4
        for each in (
            thrust / 4 + roll - pitch + yaw,
            thrust / 4 + roll + pitch - yaw,
            thrust / 4 - roll + pitch + yaw,
            thrust / 4 - roll - pitch - yaw,
        ):
            assert -1e-9 <= each <= rotors.max_thrust + 1e-9


def test_tilt_goes_before_height_and_height_before_yaw() -> None:
    drive = RotorDrive(MODEL)
    lever, ratio = MODEL.rotors.arm / sqrt(2), MODEL.rotors.drag_ratio
    x = 0.9 * lever * 2 * MODEL.rotors.max_thrust * (1 - MODEL.rotors.idle_thrust)
    for _ in range(200):
        thrust, roll, pitch, yaw = drive.step((100.0, x, 0.0, 10.0))
    assert (roll, pitch) == (pytest.approx(x), pytest.approx(0.0, abs=1e-9))
    assert thrust < MODEL.max_thrust and abs(yaw) < 10 * ratio
    for _ in range(200):
        thrust, *_, yaw = drive.step((100.0, 0.0, 0.0, 10.0))
    assert (thrust, yaw) == (pytest.approx(MODEL.max_thrust), pytest.approx(0.0, abs=1e-9))


def test_rotors_follow_with_their_time_constant() -> None:
    drive, hover = RotorDrive(MODEL), (WEIGHT, 0.0, 0.0, 0.0)
    steps = 12
    for _ in range(steps):
        thrust, *_ = drive.step(hover)
    assert thrust == pytest.approx(WEIGHT * (1 - exp(-steps / 240 / MODEL.rotors.time_constant)))


def test_tilt_does_not_lift_it() -> None:
    """However much tilt is asked for, the rotors then give no more than carries it."""
    drive = RotorDrive(load_model("f450"))
    weight = load_model("f450").weight
    for _ in range(200):
        thrust, *_ = drive.step((0.5 * weight, 10.0, 10.0, 0.0))
    assert drive.excess == pytest.approx(0.5 * weight)
    assert thrust == pytest.approx(weight)


def test_a_strong_vehicle_bears_command_noise() -> None:
    """Its rotors saturate again and again, which must not be taken for wind, nor lift it."""
    with sim_session(VehicleSpec("drone", "f450"), noise=2.0) as session:
        take_off(session, 3)
        seen = wait(session, 16)
    assert all(abs(each.position.z - 3) < 1 for each in seen)
    assert all(abs(each.yaw) < 4 * pi / 180 for each in seen)


@pytest.mark.parametrize("model", ["ardrone2", "crazyflie", "f450"])
@pytest.mark.parametrize("spin", [5.0, 30.0, 150.0])
def test_what_spins_does_not_spin_faster_by_itself(model: str, spin: float) -> None:
    """Without a torque the angular momentum stays the same, and the energy does not grow."""
    body = load_model(model)
    motion, inertia = Motion(body), body.inertia
    state: BodyState = ((0, 0, 0), (0, 0, 0, 1), (0, 0, 0), (spin, 0.1 * spin, 0.3 * spin))
    begun = [momentum_of(state, inertia), energy_of(state, inertia)]
    for _ in range(240):
        state = motion.step(state, axes_of(state[1]), (0, 0, 0), (0, 0, 0))
    left = [momentum_of(state, inertia), energy_of(state, inertia)]
    fast = spin > 10
    for axis in range(3):
        assert left[0][axis] == pytest.approx(
            begun[0][axis], abs=(0.25 if fast else 0.02) * norm(begun[0])
        )
    assert norm(left[0]) == pytest.approx(norm(begun[0]), rel=1e-9 if fast else 0.02)
    assert left[1] < begun[1] * 1.02


# Crashes.


def crashes_of(seen: list[Observation]) -> list[tuple[str, float, str]]:
    """What was told of crashes: the thing, the speed to 0.5 m/s, the reason."""
    told = [e.fields for each in seen for e in each.events if e.name == "vehicle.crashed"]
    return [(each["thing"], round(2 * each["speed"]) / 2, each["reason"]) for each in told]


@pytest.mark.parametrize("engine", ENGINES)
def test_a_hard_fall_without_motors_is_told_once(engine: str) -> None:
    with sim_session(VehicleSpec("drone"), engine=engine) as session:
        vehicle = take_off(session, 5)
        vehicle.emergency_stop()
        assert crashes_of(wait(session, 4)) == [("ground", 9.5, "it fell on the ground")]
        assert vehicle.observe().mode == "landed"
        assert decided(session, vehicle.takeoff(2.0)).reason == "it fell on the ground"
        assert decided(session, vehicle.reset()).state == "done"
        finish(session, vehicle.takeoff(2.0), 8)


@pytest.mark.parametrize("engine", ENGINES)
def test_a_soft_fall_breaks_nothing(engine: str) -> None:
    with sim_session(VehicleSpec("drone"), engine=engine) as session:
        vehicle = take_off(session, 1)
        vehicle.emergency_stop()
        assert crashes_of(wait(session, 3)) == []
        finish(session, vehicle.takeoff(2.0), 8)


@pytest.mark.parametrize("engine", ENGINES)
@pytest.mark.parametrize(("ours", "theirs"), [(3.0, 3.0), (5.5, 0.0), (4.0, 0.0)])
def test_two_that_meet_hit_each_other_with_the_speed_of_both(
    engine: str, ours: float, theirs: float
) -> None:
    """However the hit shares the speed out between them."""
    starts = [Start(Point(x, 0, 0), 0.0) for x in (-6, 6)]
    specs = [VehicleSpec(name, start=start) for name, start in zip("ab", starts, strict=True)]
    with sim_session(*specs, engine=engine) as session:
        a, b = session.vehicles["a"], session.vehicles["b"]
        for each in (a, b):
            each.configure(Limits(max_speed=8.0, max_tilt=0.5))
            each.takeoff(20)
        wait(session, 14)
        a.command(Velocity(x=ours), LONG)
        b.command(Velocity(x=-theirs), LONG)
        seen: dict[str, list[Observation]] = {"a": [], "b": []}
        for _ in range(160):
            session.wait()
            for each in (a, b):
                seen[each.name].append(each.observe())
    for name, other in (("a", "b"), ("b", "a")):
        hard = ours + theirs > MODEL.withstands
        expected = [(other, ours + theirs, f"a rotor was stopped by the {other}")]
        assert crashes_of(seen[name])[:1] == (expected if hard else [])


@pytest.mark.parametrize("engine", ENGINES)
def test_the_crash_names_what_it_bounced_off(engine: str) -> None:
    wall = thing_of("wall", Cuboid(Point(0.05, 20, 40)), (12, 0, 20))
    with sim_session(VehicleSpec("drone", "f450"), world=world_of(wall), engine=engine) as session:
        vehicle = take_off(session, 5)
        vehicle.configure(Limits(max_speed=20.0, max_tilt=0.7))
        (crash,) = crashes_of(wait(session, 4, Velocity(x=20.0)))
    assert crash[0] == "wall" and crash[2] == "a rotor was stopped by the wall"


@pytest.mark.parametrize(("physics", "crashes"), [("real", True), ("real,-crashes", False)])
def test_a_hard_impact_stops_the_rotors(physics: str, crashes: bool) -> None:
    wall = thing_of("wall", Cuboid(Point(0.3, 20, 8)), (30, 0, 4))
    with session_of(world_of(wall), physics=physics) as session:
        vehicle = take_off(session, 3)
        vehicle.configure(Limits(max_speed=9.0, max_tilt=0.6))
        seen = wait(session, 8, Velocity(x=8.0))
        expected = [("collision", "wall"), ("crashed", "wall")] if crashes else []
        assert told(seen)[: len(expected)] == expected
        assert vehicle.observe().armed is not crashes
        if not crashes:
            return
        (crash,) = (e for each in seen for e in each.events if e.name == "vehicle.crashed")
        assert 5 < crash.fields["speed"] < 9
        assert crash.fields["reason"] == "a rotor was stopped by the wall"
        wait(session, 4)
        down = vehicle.observe()
        assert down.mode == "landed" and crash.fields["reason"] in down.health
        vehicle.reset()
        wait(session, 0.1)
        assert crash.fields["reason"] not in vehicle.observe().health


def test_upside_down_it_does_not_push_itself_down() -> None:
    """Thrown on its back it falls hardly faster than a stone, and turns over."""
    with session_of(world_of()) as session:
        vehicle = take_off(session, 30)
        dynamics = vehicle.dynamics  # type: ignore[attr-defined]
        at, _, velocity, _ = dynamics.state
        dynamics.state = (at, (1.0, 0.0, 0.0, 0.0), velocity, (0.0, 0.0, 0.0))
        seen = wait(session, 3, Hold())
        for each in seen:
            assert each.velocity.z > -1.5 * G * (each.time - seen[0].time + 0.08)
        assert abs(roll_pitch_of(seen[-1].attitude)[0]) < 0.05
        assert seen[-1].position.z > 15


# Words.


@given(st.builds(Effects, *[st.booleans()] * len(REAL)))
def test_effects_are_read_as_they_are_written(effects: Effects) -> None:
    assert read_effects(plain_effects(effects)) == effects


@pytest.mark.parametrize(
    ("text", "effects"),
    [
        ("real", REAL),
        ("ideal", IDEAL),
        ("ideal,+drag, +rotors", IDEAL._replace(drag=True, rotors=True)),
        ("real,-ground_effect", REAL._replace(ground_effect=False)),
    ],
)
def test_the_words_of_effects(text: str, effects: Effects) -> None:
    assert read_effects(text) == effects


@pytest.mark.parametrize(
    ("text", "message", "hint"),
    [
        ("perfect", "'perfect' is neither 'real' nor 'ideal'", "for instance ideal,+drag"),
        ("ideal,drag", "'drag' begins with neither + nor -", "for instance real,-drag"),
        ("real,-darg", "there is no effect 'darg'", "did you mean 'drag'?"),
    ],
)
def test_unknown_words_are_told(text: str, message: str, hint: str) -> None:
    with pytest.raises(UserError) as raised:
        read_effects(text)
    fault = raised.value.faults[0]
    assert (fault.code, fault.hint) == ("bad-physics", hint)
    assert message in fault.message
