from __future__ import annotations

import ast

import pytest

from bench.mutation import chosen, equivalents, mutants_by_line
from bench.mutation_operators import mutations, optional_arguments

MODULE = '''\
"""A module."""
from __future__ import annotations

RATE: int = 40
"""Its rate."""


def clamp(value: Literal["low"], most: float = 1.5) -> float:
    """Docs."""
    if value < most and not (
        value == "ä"
    ):
        return value
    raise ValueError(f"{value + 1} is too much")
'''


@pytest.mark.parametrize(
    ("source", "expected"),
    [
        ("a < b", ["a < b → a <= b", "a < b → a >= b"]),
        ("a != b", ["a != b → a == b"]),
        ("a is None", ["a is None → a is not None"]),
        ("a < b in c",
         [f"a < b in c → {after}" for after in ("a <= b in c", "a >= b in c", "a < b not in c")]),
        ("a + b", ["a + b → a - b"]),
        ("a + 'x'", ["'x' → 'mutant'"]),
        ("A = a | b", ["a | b → a & b"]),
        ("A = Number | None", []),
        ("a and b", ["a and b → a or b"]),
        ("not a", ["not a → a"]),
        ("-a", ["-a → a"]),
        ("-1", ["1 → 2"]),
        ("a = [0, 2.5, True, '', 'word', 'two words', '12 s', None]",
         ["0 → 1", "2.5 → 3.5", "True → False", "'word' → 'mutant'", "'12 s' → 'mutant'"]),
        ("a.b = c", ["a.b = c → pass"]),
        ("a += b", ["a += b → a -= b", "a += b → pass"]),
        ("f(a, b)", ["f(a, b) → pass", "f(a, b) → f(b, a)"]),
        ("a = max(a, b)", []),
        ("a = f(*a, b.c, b)", []),
        ("a = f(g=h, i=j)", ["f(g=h, i=j) → f(i=j)"]),
        ("a = f(help='speed')", []),
        ("a = zip(b, strict=True)", []),
        ("a = cast('B', not c)", ["not c → c"]),
        ("if a: raise b", ["a → not a", "raise b → pass"]),
        ("while a < b: break", ["a < b → a <= b", "a < b → a >= b", "break → pass"]),
        ("a = [b for b in c if b]", ["b → not b"]),
        ("if TYPE_CHECKING: a()", []),
        ("if __name__ == '__main__': a()", []),
        ("__all__ = ['a']", []),
        ("assert a < b", []),
        ("match a:\n case 'b': c()", ["'b' → 'mutant'", "c() → pass"]),
    ],
)  # fmt: skip
def test_changes(source: str, expected: list[str]) -> None:
    found = mutations(source, {"f": frozenset("g")})
    assert [str(mutation) for mutation in found] == expected


def test_a_module() -> None:
    found = [
        (mutation.line, mutation.end_line, mutation.statement, mutation.at_import, str(mutation))
        for mutation in mutations(MODULE)
    ]
    both = "value < most and (not value == 'ä')"
    assert found == [
        (4, 4, 4, True, "40 → 41"),
        (8, 8, 8, True, "1.5 → 2.5"),
        (10, 10, 10, False, "value < most → value <= most"),
        (10, 10, 10, False, "value < most → value >= most"),
        (10, 12, 10, False, f"{both} → not ({both})"),
        (10, 12, 10, False, f"{both} → value < most or not value == 'ä'"),
        (10, 12, 10, False, "not value == 'ä' → value == 'ä'"),
        (11, 11, 10, False, "value == 'ä' → value != 'ä'"),
        (11, 11, 10, False, "'ä' → 'mutant'"),
        (13, 13, 13, False, "return value → return None"),
        (14, 14, 14, False, "raise ValueError(f'{value + 1} is too much') → pass"),
    ]


def test_a_mutated_module_parses_differs_in_one_place_and_keeps_its_lines() -> None:
    for mutation in mutations(MODULE):
        mutated = mutation.apply(MODULE)
        assert ast.dump(ast.parse(mutated)) != ast.dump(ast.parse(MODULE))
        rest = slice(mutation.end_line, None)
        assert mutated.splitlines()[rest] == MODULE.splitlines()[rest]
        assert mutated.splitlines()[: mutation.line - 1] == MODULE.splitlines()[: mutation.line - 1]
    first = mutations(MODULE)[0].apply(MODULE)
    assert first == MODULE.replace("40", "41")


def test_optional_arguments_are_what_all_of_one_name_share() -> None:
    sources = [
        "def f(a, b=1, *, c, d=2): pass",
        "class F:\n  x: int\n  y: int = 0\n  def f(self, b=1): pass",
        "class G:\n  def __init__(self, p, q=0): pass",
    ]
    assert optional_arguments(sources) == {
        "f": frozenset("b"), "F": frozenset("y"), "G": frozenset("q"),
    }  # fmt: skip


def test_the_same_seed_draws_the_same_mutants_of_different_lines() -> None:
    by_line = mutants_by_line({"a.py": "a = 0\n" * 50 + "b = a + 1\n"})
    assert len(by_line) == 51
    assert [mutant.key for mutant in by_line["a.py", 51]] == [
        ("a.py", "b = a + 1", "a + 1 → a - 1"), ("a.py", "b = a + 1", "1 → 2"),
    ]  # fmt: skip
    drawn = chosen(by_line, 20, seed=3)
    assert drawn == chosen(by_line, 20, seed=3) != chosen(by_line, 20, seed=4)
    assert len({mutant.place for mutant in drawn}) == 20
    assert len(chosen(by_line, 99, seed=3)) == 51


def test_equivalents() -> None:
    text = "# About.\n\na.py\nb = a + 1\n1 → 2\nNobody reads b.\n\nc.py\nd()\nd() → pass\nIdle.\n"
    assert equivalents(text) == {
        ("a.py", "b = a + 1", "1 → 2"): "Nobody reads b.",
        ("c.py", "d()", "d() → pass"): "Idle.",
    }
    assert equivalents("# Nothing yet.\n") == {}
    with pytest.raises(ValueError, match=r"four lines are needed, not these:\na\.py\nb$"):
        equivalents("a.py\nb\n")
