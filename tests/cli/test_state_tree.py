"""The tree of states in few rows: the active ones are always in sight."""

from __future__ import annotations

from hypothesis import given, settings
from hypothesis import strategies as st

from behaviors import drone_vocabulary
from cli.state_tree import draw_tree
from fsm import Instance, compile_mission, read_mission_text
from tests.behaviors.flying import Rig


def tree_of(shape: list[object], depth: int = 1, name: str = "s") -> list[str]:
    """The lines of a mission's states: a list is a state with states, None a leaf."""
    lines = []
    for number, inside in enumerate(shape):
        own = f"{name}{number}"
        lines.append("  " * depth + f"{own}:" + ("" if inside else " {after: {1 h: " + own + "}}"))
        if inside:
            assert isinstance(inside, list)
            lines += ["  " * (depth + 1) + "states:", *tree_of(inside, depth + 2, own + "_")]
    return lines


SHAPES = st.recursive(
    st.none(), lambda inside: st.lists(inside, min_size=1, max_size=5), max_leaves=60
)


@settings(max_examples=50, deadline=None)
@given(st.lists(SHAPES, min_size=1, max_size=6), st.integers(1, 30), st.integers(10, 60), st.data())
def test_rows_are_few_enough_and_the_active_leaf_is_among_them(
    shape: list[object], rows: int, columns: int, data: st.DataObject
) -> None:
    text = "\n".join(["mission: tree", "states:", *tree_of(shape)])
    graph = compile_mission(read_mission_text(text, "tree.yaml"), drone_vocabulary())
    leaf = data.draw(st.sampled_from([node for node in graph.nodes if not node.children]))
    drawn = draw_tree(_started(text, leaf.path), leaf.path, columns, rows)
    assert len(drawn) <= rows
    assert {line.cell_len for line in drawn} == {columns}
    marked = [line.plain.strip() for line in drawn if "▶" in line.plain]
    assert len(marked) == 1
    name = marked[0].removeprefix("▶ ").partition("…")[0].partition("  ")[0].strip()
    assert name and leaf.local_name.startswith(name)


def _started(text: str, initial: str) -> Instance:
    """An instance in the state of this path."""
    rig = Rig(text.replace("states:", f"initial: {initial}\nstates:", 1))
    rig.period()
    assert rig.pilot.instance.is_active(initial)
    return rig.pilot.instance


PARALLEL = """\
mission: regions
states:
  both:
    type: parallel
    states:
""" + "\n".join(
    f"      r{n}: {{states: {{{', '.join(f's{k}: {{after: {{1 h: s{k}}}}}' for k in range(9))}}}}}"
    for n in range(10)
)


def test_of_many_regions_the_leaves_come_first() -> None:
    rig = Rig(PARALLEL)
    rig.period()
    drawn = [line.plain.strip() for line in draw_tree(rig.pilot.instance, "", 40, 10)]
    assert sum(line.startswith("▶ s0") for line in drawn) >= 4
    everything = [line.plain for line in draw_tree(rig.pilot.instance, "", 40, 200)]
    assert len(everything) == 101
    assert sum("▶" in line for line in everything) == 10


def test_what_is_left_out_is_counted() -> None:
    states = "\n".join(f"  s{n}: {{after: {{1 h: s{n}}}}}" for n in range(100))
    instance = _started(f"mission: row\nstates:\n{states}\n", "s50")
    drawn = [line.plain.strip() for line in draw_tree(instance, "s50", 30, 9)]
    assert drawn == [
        *("⋮ 47 more", "· s47", "· s48", "· s49", "▶ s50  0.0 s", "· s51", "· s52", "· s53"),
        "⋮ 46 more",
    ]


def test_after_the_end_the_last_state_is_in_sight() -> None:
    states = "\n".join(f"  s{n}: {{after: {{25 ms: s{n + 1}}}}}" for n in range(30))
    rig = Rig(
        f"mission: row\nstates:\n{states}\n  s30: {{type: final}}\n  s31: {{after: {{1 h: s31}}}}"
    )
    rig.run(2.0)
    assert rig.pilot.outcome == "done"
    drawn = [line.plain.strip() for line in draw_tree(rig.pilot.instance, "s30", 30, 6)]
    assert "■ s30" in drawn
