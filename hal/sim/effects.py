"""The effects that the simulator computes: from an ideal vehicle to everything that is modelled."""

from __future__ import annotations

from typing import NamedTuple

from vencejo.errors import UserError, nearest


class Effects(NamedTuple):
    """What is computed beyond thrust, gravity and contact; True for all that is."""

    rotors: bool = True
    """Four rotors, each between its least and its largest thrust, that lag behind the command."""
    drag: bool = True
    """The drag of the body and of the rotors, and by it the wind."""
    ground_effect: bool = True
    """More thrust near the ground."""
    power: bool = True
    """Power that depends on the speed through the air, and idling rotors that draw some."""
    sag: bool = True
    """A battery whose voltage limits the thrust."""
    crashes: bool = True
    """Impacts that stop the rotors."""
    downwash: bool = True
    """The air that other vehicles push down."""


REAL = Effects()
IDEAL = Effects(*[False] * len(REAL))
_BASES = {"real": REAL, "ideal": IDEAL}


def read_effects(text: str) -> Effects:
    """Effects in words: ``real`` or ``ideal``, then ``+effect`` or ``-effect`` after commas.

    Raises UserError (``bad-physics``).
    """
    base, *changes = (part.strip() for part in text.split(","))
    if base not in _BASES:
        raise _bad(f"'{base}' is neither 'real' nor 'ideal'", "for instance ideal,+drag")
    effects = _BASES[base]
    for change in changes:
        sign, name = change[:1], change[1:]
        if sign not in ("+", "-"):
            raise _bad(f"'{change}' begins with neither + nor -", "for instance real,-drag")
        if name not in Effects._fields:
            raise _bad(f"there is no effect '{name}'", nearest(name, Effects._fields))
        effects = effects._replace(**{name: sign == "+"})
    return effects


def plain_effects(effects: Effects) -> str:
    """The shortest words from which :func:`read_effects` reads the same."""
    base = "real" if 2 * sum(effects) > len(effects) else "ideal"
    sign, named = ("-", False) if base == "real" else ("+", True)
    changed = (name for name, on in effects._asdict().items() if on == named)
    return ",".join([base, *(sign + name for name in changed)])


def _bad(message: str, hint: str | None) -> UserError:
    return UserError("bad-physics", f"--physics: {message}", hint=hint)
