"""Faults and hints, and the generators of a run."""

from __future__ import annotations

import pytest

from vencejo.errors import Fault, UserError, VehicleError, Where, nearest
from vencejo.seeds import generator


def test_a_fault_reads_as_place_sentence_code_and_hint() -> None:
    fault = Fault(
        "unknown-key", "there is no 'stats'", Where("m.yaml", 3, 5), "did you mean 'states'?"
    )
    assert str(fault) == (
        "m.yaml:3:5: error: there is no 'stats' [unknown-key]\n  hint: did you mean 'states'?"
    )
    assert str(Fault("odd", "it is odd", severity="warning")) == "warning: it is odd [odd]"
    assert str(Where("m.yaml")) == "m.yaml"
    assert Where("m.yaml", 3, 5).right(4) == Where("m.yaml", 3, 9)


def test_one_error_carries_several_faults() -> None:
    faults = [Fault("a", "first"), Fault("b", "second")]
    error = UserError.of(faults)
    assert error.faults == tuple(faults)
    assert (error.code, str(error)) == ("a", "error: first [a]\nerror: second [b]")
    assert (UserError("a", "x").exit_code, VehicleError("a", "x").exit_code) == (2, 3)


@pytest.mark.parametrize(
    ("word", "known", "otherwise", "hint"),
    [
        ("stats", ["states", "data"], None, "did you mean 'states'?"),
        ("zzz", ["b", "a"], None, "known: a, b"),
        ("zzz", ["a"], "see the manual", "see the manual"),
        ("zzz", [], None, None),
        (
            "zzz",
            [f"n{i:02}" for i in range(20)],
            None,
            "known: " + ", ".join(f"n{i:02}" for i in range(12)) + ", …",
        ),
        ("blide", [f"a{i}" for i in range(999)] + ["glide", "slid"], None, "did you mean 'glide'?"),
        ("glied", [f"g{i}" for i in range(99)] + ["glide", "slid"], None, "did you mean 'glide'?"),
    ],
)
def test_nearest(word: str, known: list[str], otherwise: str | None, hint: str | None) -> None:
    assert nearest(word, known, otherwise) == hint


def test_generators_depend_on_seed_and_names_alone() -> None:
    def draws(seed: int, *names: str) -> list[float]:
        made = generator(seed, *names)
        return [made.random() for _ in range(3)]

    assert draws(0, "a", "b") == draws(0, "a", "b")
    different = [draws(0, "a"), draws(1, "a"), draws(0, "b"), draws(0, "a", "b"), draws(0, "ab")]
    assert len({tuple(found) for found in different}) == 5
    assert draws(7, "wind")[0] == generator(7, "wind").random()


def test_a_wrong_first_letter_is_found_among_many_words() -> None:
    words = [f"{letter}{number}_word" for letter in "abcdefgh" for number in range(12)]
    assert nearest("xake_off", [*words, "take_off"]) == "did you mean 'take_off'?"
