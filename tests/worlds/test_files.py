"""Pictures, meshes and models from the user's disk."""

from __future__ import annotations

from math import pi
from pathlib import Path

import cv2
import numpy as np
import pytest

from vencejo.errors import UserError
from vencejo.geometry import Point, turned
from worlds import World, load_world
from worlds.mesh_files import load_mesh
from worlds.model_files import load_model
from worlds.things import Cuboid, Cylinder, Image, Mesh, Sphere

PICTURE = np.zeros((4, 4, 3), np.uint8)
WEDGE = """\
# a wedge of five faces
v 0 0 0
v 2 0 0
v 2 1 0
v 0 1 0
v 0 0 1
v 0 1 1
vn 0 0 1
f 1 4 3 2
f 1/1/1 2/1/1 5/1/1
f -4//1 4//1 6//1
f 2 3 6 5
f 1 5 6 4
"""
STL = """\
solid tip
 facet normal 0 0 1
  outer loop
   vertex 0 0 0
   vertex 1 0 0
   vertex 0 1 0
  endloop
 endfacet
endsolid
"""


def loaded(folder: Path, text: str) -> World:
    (folder / "w.yaml").write_text(f"world: w\nstart: {{at: [50, 50]}}\n{text}\n")
    return load_world(folder / "w.yaml")


def fault(folder: Path, text: str) -> str:
    with pytest.raises(UserError) as caught:
        loaded(folder, text)
    (found,) = caught.value.faults
    assert found.where is not None and found.where.line == 3
    return f"{found.code}: {found.message}".replace(str(folder), ".")


def test_pictures_are_found_beside_the_world(tmp_path: Path) -> None:
    cv2.imwrite(str(tmp_path / "grass.jpg"), PICTURE)
    cv2.imwrite(str(tmp_path / "crate.png"), PICTURE)
    world = loaded(
        tmp_path,
        "ground: {texture: grass.jpg, tile: 4 m}\n"
        "boxes: {b: {at: [0, 0], size: [1, 1, 1], texture: crate.png}}\n"
        "signs: {s: {at: [5, 5], texture: crate.png}}",
    )
    assert (world.ground.texture, world.ground.tile) == (tmp_path / "grass.jpg", 4.0)
    box, sign = world.things
    assert box.parts[0].texture == sign.parts[-1].texture == Image(tmp_path / "crate.png")


@pytest.mark.parametrize(
    ("name", "content", "message"),
    [
        ("cut.png", b"", "the PNG file is broken or cut short"),
        ("cut.jpg", b"", "the JPEG file is cut short"),
        ("text.png", b"hello", "it is neither PNG nor JPEG"),
    ],
)
def test_a_broken_picture_is_told(tmp_path: Path, name: str, content: bytes, message: str) -> None:
    if not content:
        done, data = cv2.imencode(Path(name).suffix, np.zeros((90, 90, 3), np.uint8))
        assert done
        content = data.tobytes()[:-5]
    (tmp_path / name).write_bytes(content)
    found = fault(tmp_path, f"ground: {{texture: {name}}}")
    assert found == f"bad-picture: './{name}' cannot be shown: {message}"


def test_a_flipped_bit_breaks_a_png(tmp_path: Path) -> None:
    cv2.imwrite(str(tmp_path / "a.png"), PICTURE)
    data = bytearray((tmp_path / "a.png").read_bytes())
    data[45] ^= 1
    (tmp_path / "a.png").write_bytes(data)
    assert "broken" in fault(tmp_path, "ground: {texture: a.png}")


def test_a_missing_file_names_the_nearest(tmp_path: Path) -> None:
    cv2.imwrite(str(tmp_path / "grass.png"), PICTURE)
    with pytest.raises(UserError, match=r"did you mean 'grass\.png'"):
        loaded(tmp_path, "ground: {texture: gras.png}")


def test_the_hash_covers_the_files(tmp_path: Path) -> None:
    text = "ground: {texture: a.png}"
    cv2.imwrite(str(tmp_path / "a.png"), PICTURE)
    first = loaded(tmp_path, text).sha256
    assert first == loaded(tmp_path, text).sha256
    cv2.imwrite(str(tmp_path / "a.png"), PICTURE + 1)
    assert first != loaded(tmp_path, text).sha256


def volume(mesh: Mesh) -> float:
    a, b, c = (mesh.vertices[mesh.faces[:, k]] for k in range(3))
    return float((np.cross(a, b) * c).sum() / 6)


def test_an_obj_is_read(tmp_path: Path) -> None:
    (tmp_path / "wedge.obj").write_text(WEDGE)
    mesh = load_mesh(tmp_path / "wedge.obj")
    assert (mesh.vertices.shape, mesh.faces.shape) == ((6, 3), (8, 3))
    assert volume(mesh) == pytest.approx(1.0)
    (thing,) = loaded(
        tmp_path, "meshes: {m: {at: [0, 0], file: wedge.obj, scale: 2, color: red}}"
    ).things
    shape = thing.parts[0].shape
    assert isinstance(shape, Mesh) and volume(shape) == pytest.approx(8.0)


def test_an_stl_is_read_as_text_and_binary(tmp_path: Path) -> None:
    (tmp_path / "text.stl").write_text(STL)
    floats = np.array([[0, 0, 1], [0, 0, 0], [1, 0, 0], [0, 1, 0]], "<f4").tobytes()
    head = b"solid, says this binary file too".ljust(80) + (1).to_bytes(4, "little")
    (tmp_path / "binary.stl").write_bytes(head + floats + b"\0\0")
    for name in ("text.stl", "binary.stl"):
        mesh = load_mesh(tmp_path / name)
        corners = mesh.vertices[mesh.faces[0]].tolist()
        assert corners == [[0, 0, 0], [1, 0, 0], [0, 1, 0]]


@pytest.mark.parametrize(
    ("name", "content", "message"),
    [
        ("m.dae", "x", "files end in .obj or .stl, not '.dae'"),
        ("m.obj", "# nothing", "it has no triangles"),
        ("m.obj", "v 0 0\n", "line 1 cannot be read: v 0 0"),
        ("m.obj", "v 0 0 0\nf 1 1 2\n", "a face names a corner that is not there"),
        ("m.obj", "v 0 0 0\nf 1 1 -2\n", "a face names a corner that is not there"),
        ("m.obj", "v 0 0 0\nf 1 x 1\n", "line 2 cannot be read: f 1 x 1"),
        ("m.obj", "v 0 0 nan\nf 1 1 1\n", "a coordinate is no finite number"),
        ("m.stl", STL.replace("vertex 0 1 0", ""), "a triangle is not complete"),
        ("m.stl", STL.replace("0 1 0", "0 one 0"), "a vertex is not three numbers"),
        ("m.stl", "binary?", "the STL file is broken or cut short"),
    ],
)
def test_a_broken_mesh_is_told(tmp_path: Path, name: str, content: str, message: str) -> None:
    (tmp_path / name).write_text(content)
    found = fault(tmp_path, f"meshes: {{m: {{at: [0, 0], file: {name}}}}}")
    assert found == f"bad-mesh: './{name}' is no mesh: {message}"


URDF = """\
<robot name="arm">
  <material name="tin"><color rgba="0.2 0.4 0.6 1"/></material>
  <link name="base">
    <visual><geometry><cylinder radius="0.5" length="1"/></geometry><material name="tin"/></visual>
    <collision><geometry><box size="9 9 9"/></geometry></collision>
  </link>
  <joint name="j" type="revolute">
    <parent link="base"/><child link="arm"/><origin xyz="0 0 1" rpy="0 0 1.5707963267948966"/>
  </joint>
  <link name="arm">
    <visual><origin xyz="1 0 0"/><geometry><box size="2 0.2 0.2"/></geometry></visual>
  </link>
  <joint name="k" type="fixed">
    <parent link="arm"/><child link="tip"/><origin xyz="2 0 0"/>
  </joint>
  <link name="tip"><collision><geometry><sphere radius="0.1"/></geometry></collision></link>
</robot>
"""
SDF = """\
<sdf version="1.6"><model name="lamp"><pose>0 0 1 0 0 0</pose>
  <link name="l"><pose>1 0 0 0 0 1.5707963267948966</pose>
    <visual name="v"><pose>1 0 0 0 0 0</pose>
      <geometry><mesh><uri>wedge.obj</uri><scale>1 1 2</scale></mesh></geometry>
      <material><diffuse>1 0 0 1</diffuse></material>
    </visual>
  </link>
</model></sdf>
"""


def test_a_urdf_is_read(tmp_path: Path) -> None:
    (tmp_path / "arm.urdf").write_text(URDF)
    base, arm, tip = load_model(tmp_path / "arm.urdf")
    assert (base.shape, base.at, base.color) == (Cylinder(0.5, 1.0), Point(0, 0, 0), (51, 102, 153))
    assert (arm.shape, arm.at) == (Cuboid(Point(2, 0.2, 0.2)), pytest.approx((0, 1, 1)))
    assert turned((1, 0, 0), arm.attitude) == pytest.approx((0, 1, 0))
    assert (tip.shape, tip.at) == (Sphere(0.1), pytest.approx((0, 2, 1)))
    (thing,) = loaded(tmp_path, "models: {a: {at: [3, 4], file: arm.urdf}}").things
    assert (thing.kind, len(thing.parts), thing.solid) == ("model", 3, True)


@pytest.mark.parametrize(
    ("name", "text"),
    [
        ("m.urdf", '<robot><link name="a"><visual><geometry><mesh filename="in/w.obj"/></geometry>'
         "</visual></link></robot>"),
        ("m.sdf", '<sdf><model name="m"><link name="a"><visual><geometry><mesh><uri>in/w.obj</uri>'
         "</mesh></geometry></visual></link></model></sdf>"),
    ],
)  # fmt: skip
def test_the_meshes_of_a_model_are_files_of_the_world(name: str, text: str, tmp_path: Path) -> None:
    (tmp_path / "in").mkdir()
    (tmp_path / "in" / "w.obj").write_text(WEDGE)
    (tmp_path / name).write_text(text)
    world = loaded(tmp_path, f"models: {{m: {{at: [0, 0], file: {name}}}}}")
    assert [path.name for path in world.files[1:]] == [name, "w.obj"]
    (tmp_path / "in" / "w.obj").write_text(WEDGE.replace("v 2 1 0", "v 3 1 0"))
    again = loaded(tmp_path, f"models: {{m: {{at: [0, 0], file: {name}}}}}")
    assert again.sha256 != world.sha256


def test_an_sdf_is_read(tmp_path: Path) -> None:
    (tmp_path / "wedge.obj").write_text(WEDGE)
    (tmp_path / "lamp.sdf").write_text(SDF)
    (part,) = load_model(tmp_path / "lamp.sdf")
    assert (part.at, part.color) == (pytest.approx((1, 1, 1)), (255, 0, 0))
    assert isinstance(part.shape, Mesh) and volume(part.shape) == pytest.approx(2.0)


def test_the_poses_of_an_sdf_follow_each_other(tmp_path: Path) -> None:
    """The visual's is counted from its link, the link's from its model, the model's from all."""
    (tmp_path / "m.sdf").write_text(
        f"""<sdf version="1.6"><model name="m"><pose>1 2 3 0 0 {pi / 2}</pose>
        <link name="l"><pose>1 0 0 0 {pi / 2} 0</pose>
        <visual name="v"><pose>0 0 1 0 0 0</pose>
        <geometry><box><size>1 2 3</size></box></geometry></visual></link></model></sdf>"""
    )
    (part,) = load_model(tmp_path / "m.sdf")
    assert (part.shape, part.at) == (Cuboid(Point(1, 2, 3)), pytest.approx((1, 4, 3)))
    # Pitched down in the link, which the model turns to the left.
    assert turned((1, 0, 0), part.attitude) == pytest.approx((0, 0, -1))
    assert turned((0, 1, 0), part.attitude) == pytest.approx((-1, 0, 0))


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("<robot", "it is no XML"),
        ("<html/>", "its root is <html>"),
        ("<robot/>", "none of its links has a shape"),
        (URDF.replace("cylinder", "capsule"), "the shape <capsule> is not known"),
        (URDF.replace('parent link="base"', 'parent link="bas"'), "unknown link 'bas'"),
        (URDF.replace('parent link="base"', 'parent link="tip"'), "lead in a circle"),
        (URDF.replace('radius="0.5"', 'radius="-1"'), "must be above 0"),
        (URDF.replace('radius="0.5"', ""), "a <cylinder> has no radius"),
        (URDF.replace("0 0 1", "0 0 up"), "'0 0 up' is not 3 numbers"),
        (
            '<robot xmlns:xacro="http://ros.org/wiki/xacro"><xacro:macro/></robot>',
            "xacro is a macro language",
        ),
        ('<!DOCTYPE r [<!ENTITY a "b">]><robot/>', "entities are not read"),
        (SDF.replace("<pose>1", '<pose relative_to="x">1'), "relative to another frame"),
        (SDF.replace("wedge.obj", "model://wedge.obj"), "give its path"),
        (SDF, "there is no mesh"),
        ("<sdf><world><include/></world></sdf>", "<include> is not read"),
    ],
)
def test_what_a_model_cannot_have_is_told(tmp_path: Path, text: str, message: str) -> None:
    (tmp_path / "m.urdf").write_text(text)
    found = fault(tmp_path, "models: {m: {at: [0, 0], file: m.urdf}}")
    assert found.startswith("bad-model: './m.urdf' cannot be used: ") and message in found


def test_a_joint_turns_its_child(tmp_path: Path) -> None:
    (tmp_path / "m.urdf").write_text(URDF.replace("0 0 1.5707963267948966", f"0 {pi / 2} 0"))
    arm = load_model(tmp_path / "m.urdf")[1]
    assert arm.at == pytest.approx((0, 0, 0))
