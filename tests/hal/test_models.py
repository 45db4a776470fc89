"""Models of vehicles: those that are shipped, files of others, and what no vehicle can be."""

from __future__ import annotations

from math import pi, radians
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from hal import Limits, VehicleSpec, backend_capabilities, flight_model, vehicle_model
from hal.engines import open_engine
from hal.sim import SimSession, open_session
from hal.sim.model import BatteryPack, Drag, Model, Rotors
from hal.sim.model_files import load_model, model_names
from hal.vehicle import Options
from tests.hal.flying import take_off, wait
from vencejo.errors import UserError
from worlds.loader import load_world, read_world

SHIPPED = ("ardrone1", "ardrone2", "crazyflie", "f450")
ARDRONE2 = (Path(load_model.__code__.co_filename).parent / "models/ardrone2.yaml").read_text()


def faults(tmp_path: Path, text: str) -> list[tuple[int, str, str, str | None]]:
    """The faults of a model's file: line, code, message, hint."""
    path = tmp_path / "mine.yaml"
    path.write_text(text)
    with pytest.raises(UserError) as error:
        load_model(str(path))
    return [
        (fault.where.line if fault.where else 0, fault.code, fault.message, fault.hint)
        for fault in error.value.faults
    ]


def line_of(text: str, begin: str) -> int:
    return next(n for n, line in enumerate(text.splitlines(), 1) if line.strip().startswith(begin))


def changed(*changes: tuple[str, str]) -> str:
    """The file of the AR.Drone 2.0 with other texts."""
    text = ARDRONE2
    for old, new in changes:
        assert old in text
        text = text.replace(old, new, 1)
    return text


def test_the_shipped_models() -> None:
    assert tuple(model_names()) == SHIPPED
    assert [load_model(name).name for name in SHIPPED] == [*SHIPPED]
    for name in SHIPPED:
        model = load_model(name)
        assert model.max_tilt <= model.steepest
        assert 1.9 < model.max_thrust / model.weight < 3
        assert 7 * 60 - 30 < model.endurance < 13 * 60


def test_every_constant_says_where_it_comes_from() -> None:
    """Each line with a number has a comment, or the line above it is one."""
    for name in SHIPPED:
        path = Path(load_model.__code__.co_filename).parent / f"models/{name}.yaml"
        lines = path.read_text().splitlines()
        for before, line in zip(["", *lines], lines, strict=False):
            key, _, value = line.partition(":")
            told = "#" in line or "#" in before or before.strip().startswith(key.strip())
            numbers = any(letter.isdigit() for letter in value) and key != "description"
            continued = line.startswith("           ") or key in ("model", "  ventral")
            assert told or not numbers or continued, f"{name}: {line}"


def test_the_ar_drone_is_what_it_was() -> None:
    model = load_model("ardrone2")
    assert model == load_model()
    assert (model.mass, model.size) == (0.436, (0.52, 0.52, 0.12))
    assert model.inertia == (2.237568e-3, 2.985236e-3, 4.80374e-3)
    assert model.rotors == Rotors(0.1785, 0.1, 2.125, 0.05, 0.0301, 0.02, 0.3258)
    assert model.drag == Drag(0.005, 0.25)
    assert model.battery == BatteryPack(11.1 * 3600, 12.6, 9.6, 0.06, 5.0)
    limits = model.max_speed, model.max_climb, model.max_tilt, model.max_yaw_rate
    assert limits == pytest.approx((5.0, 2.0, radians(20), 1.75))
    assert model.profiles["indoor"] == Limits(2.0, 0.7, 0.21, 1.75, 0.05, 3.0)
    assert model.profiles["outdoor"].given() == pytest.approx(
        Limits(5.0, 2.0, radians(20), 3.5, 0.05, 100.0).given()
    )
    assert (model.steepest_ground, model.withstands) == pytest.approx((radians(25), 5.0))
    assert model.one_active_camera and list(model.cameras) == ["front", "ventral"]
    assert model.cameras["ventral"].tilt == pytest.approx(pi / 2)


def test_a_model_tells_of_the_wind_if_its_autopilot_does() -> None:
    estimating = {name for name in SHIPPED if "wind" in backend_capabilities("sim", name)}
    assert estimating == {"ardrone2", "f450"}


def test_the_450_class_frame_may_tilt_far_and_the_crazyflie_sees_nothing() -> None:
    f450, crazyflie = load_model("f450"), load_model("crazyflie")
    assert f450.max_tilt >= radians(35) and not f450.one_active_camera
    assert crazyflie.cameras == {} and "outdoor" not in crazyflie.profiles
    assert crazyflie.color == (40, 40, 45)


@pytest.mark.parametrize("name", SHIPPED)
def test_every_model_takes_off_hovers_and_lands(name: str) -> None:
    with SimSession(
        Options((VehicleSpec("drone", name),)), read_world("world: t", "t"), open_engine()
    ) as session:
        drone = take_off(session, 1.0)
        assert drone.model == name
        seen = wait(session, 3)[-1]
        assert seen.position == pytest.approx((0, 0, 1), abs=0.02)
        drone.land()
        seen = wait(session, 6)[-1]
        assert (seen.flying, seen.mode) == (False, "landed")
        assert seen.position.z == pytest.approx(0, abs=0.01)


def test_the_model_of_a_vehicle_counts_over_the_worlds() -> None:
    world = read_world("world: t\nmodel: crazyflie", "t")
    options = Options((VehicleSpec("own", "f450"), VehicleSpec("other")))
    with SimSession(options, world, open_engine()) as session:
        assert [vehicle.model for vehicle in session.vehicles.values()] == ["f450", "crazyflie"]
        assert "camera.front" in session.vehicles["own"].capabilities
        assert "camera.front" not in session.vehicles["other"].capabilities
        assert set(session.vehicles["other"].profiles) == {"indoor"}


def test_a_world_names_a_model_from_its_own_folder(tmp_path: Path) -> None:
    (tmp_path / "mine.yaml").write_text(changed(("model: ardrone2", "model: mine")))
    (tmp_path / "world.yaml").write_text("world: t\nmodel: mine.yaml\n")
    world = load_world(tmp_path / "world.yaml")
    assert world.model == str(tmp_path / "mine.yaml")
    assert world.files == (tmp_path / "world.yaml", tmp_path / "mine.yaml")
    with SimSession(Options(), world, open_engine()) as session:
        assert session.vehicles["drone"].model == "mine"


def test_cameras_can_be_mounted_on_a_model_without_any() -> None:
    options = Options(
        (VehicleSpec("drone", "crazyflie"),),
        settings={"cameras": {"front": {"width": 64, "height": 48}}},
    )
    with open_session(options) as session:
        drone = session.vehicles["drone"]
        assert {word for word in drone.capabilities if "camera" in word} == {"camera.front"}
        frame = drone.camera("front").latest()
        assert frame is not None and frame.image.shape == (48, 64, 3)


def test_a_backend_tells_of_its_models_without_being_opened() -> None:
    model = vehicle_model("sim", "crazyflie")
    assert model is not None and model.name == "crazyflie"
    assert model.capabilities == backend_capabilities("sim", "crazyflie")
    assert "camera.front" in backend_capabilities("sim")
    assert "camera.front" not in model.capabilities
    flight = flight_model("sim", "crazyflie")
    assert flight is not None and set(flight.profiles) == {"indoor"}
    with pytest.raises(UserError) as error:
        vehicle_model("mavlink", "crazyflie")
    assert error.value.code == "no-models"


def test_a_model_that_is_not_there_gets_the_nearest() -> None:
    with pytest.raises(UserError) as error:
        load_model("crazyfly")
    (fault,) = error.value.faults
    assert (fault.code, fault.hint) == ("unknown-model", "did you mean 'crazyflie'?")


IMPOSSIBLE = {
    "hover": (
        [("max_thrust: 2.125 N", "max_thrust: 1 N")],
        "max_thrust",
        "it cannot hover: its four rotors give 4 N at most, and it weighs 4.28 N",
    ),
    "reserve": ([("max_thrust: 2.125 N", "max_thrust: 1.2 N")], "max_thrust", "it cannot hover"),
    "triangle": (
        [("4.80374e-3]", "5.3e-3]")],
        "inertia",
        "no body has an inertia of 0.0053 kg m² about z: it is more than about the two others",
    ),
    "too much": (
        [("[2.237568e-3, 2.985236e-3, 4.80374e-3]", "[0.0323, 0.0329, 0.048]")],
        "inertia",
        "0.436 kg in this box cannot have 0.0329 kg m² about y",
    ),
    "overlap": ([("radius: 10 cm", "radius: 17 cm")], "radius", "cover each other"),
    "reach": ([("arm: 178.5 mm", "arm: 30 cm")], "size", "its rotors reach 0.624 m"),
    "tilt": (
        [("max_tilt: 20 deg  ", "max_tilt: 65 deg  ")],
        "max_tilt",
        "tilted by 65 deg its rotors do not carry it",
    ),
    "profile": ([("max_tilt: 0.21 rad", "max_tilt: 1.3 rad")], "indoor", "tilted by 74.5 deg"),
    "voltage": (
        [("full: 12.6 V", "full: 9.6 V")],
        "empty",
        "an empty battery has less than a full one: not 9.6 V of 9.6 V",
    ),
    "power": (
        [("resistance: 0.06 ohm", "resistance: 2 ohm")],
        "resistance",
        "this battery cannot give the 53.9 W that hovering takes",
    ),
}


@pytest.mark.parametrize("kind", IMPOSSIBLE)
def test_what_no_vehicle_can_be_is_refused_with_the_reason(kind: str, tmp_path: Path) -> None:
    changes, begin, message = IMPOSSIBLE[kind]
    text = changed(*changes)
    found = faults(tmp_path, text)
    assert [code for _, code, *_ in found] == ["impossible-model"] * len(found)
    assert any(line == line_of(text, begin) and message in told for line, _, told, _ in found)
    assert all(hint for *_, hint in found)


@pytest.mark.parametrize(
    ("changes", "begin", "code", "told"),
    [
        ([("mass: 436 g", "mass: -436 g")], "mass", "bad-size", "must be above 0"),
        ([("mass: 436 g", "mass: 0")], "mass", "bad-size", "must be above 0"),
        ([("mass: 436 g", "mass: 436 m")], "mass", "wrong-dimension", "a mass is needed"),
        ([("mass: 436 g", "mas: 436 g")], "mas:", "unknown-key", "a model has no 'mas'"),
        ([("  idle: 5 %", "  ilde: 5 %")], "ilde", "unknown-key", "the rotors has no 'ilde'"),
        ([("full: 12.6 V", "full: 12.6 W")], "full", "wrong-dimension", "a voltage is needed"),
        ([("size: [52 cm, 52 cm, 12 cm]", "size: [1, 1]")], "size", "wrong-type", "a size is"),
        ([("{at: [0.2, 0, 0.02]}", "{rate: 500 Hz}")], "front", "bad-setting", "has a rate of"),
        ([("front: {at", "Front: {at")], "Front", "bad-name", "'Front' is no name"),
        ([("max_altitude: 3 m", "max_altitude: 3 cm")], "min_alt", "bad-limit", "must be below"),
    ],
)
def test_mistakes_in_a_file_are_told_with_their_place(
    changes: list[tuple[str, str]], begin: str, code: str, told: str, tmp_path: Path
) -> None:
    text = changed(*changes)
    found = faults(tmp_path, text)
    assert any(
        (line, what) == (line_of(text, begin), code) and told in message
        for line, what, message, _ in found
    ), found


def test_all_mistakes_are_told_at_once(tmp_path: Path) -> None:
    text = changed(("mass: 436 g", "mass: 0"), ("radius: 10 cm", "radius: x"))
    assert [code for _, code, *_ in faults(tmp_path, text)] == ["bad-size", "wrong-type"]


@given(
    st.lists(st.tuples(st.floats(-1, 1), st.floats(-1, 1), st.floats(-1, 1)), min_size=4),
    st.floats(0.05, 5),
)
def test_no_inertia_that_a_body_has_is_refused(
    points: list[tuple[float, float, float]], mass: float
) -> None:
    """Any masses in the box: about its axes they have an inertia that passes."""
    from dataclasses import replace

    from hal.sim.plausibility import impossibilities

    model = load_model("f450")
    half = [side / 2 for side in model.size]
    each = mass / len(points)
    about = [0.0, 0.0, 0.0]
    for point in points:
        x, y, z = (share * reach for share, reach in zip(point, half, strict=True))
        about[0] += each * (y * y + z * z)
        about[1] += each * (x * x + z * z)
        about[2] += each * (x * x + y * y)
    body: Model = replace(model, mass=mass, inertia=(about[0], about[1], about[2]))
    assert not [found for found in impossibilities(body) if found.path == ("inertia",)]
