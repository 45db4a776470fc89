"""The colours in which views tell several vehicles apart: those of their hulls."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from hal.lights import Rgb

_DARKEST, _LIGHTEST = 45.0, 180.0
"""Bounds of the luminance within which a line is seen on black and on white, 0 to 255."""
_UNLIKE = 60
"""Least sum of the differences of red, green and blue between two vehicles' colours."""


def vehicle_colors(hulls: Mapping[str, Rgb | None], others: Sequence[Rgb]) -> dict[str, Rgb]:
    """A colour for each vehicle: its hull's, or where that is not known or nearly that of a vehicle
    before it one of ``others``.
    """
    found: dict[str, Rgb] = {}
    for name, hull in hulls.items():
        choice = [legible(hull), *others] if hull else others
        taken = list(found.values())
        free = (color for color in choice if not any(_alike(color, other) for other in taken))
        found[name] = next(free, others[len(found) % len(others)])
    return found


def _alike(one: Rgb, other: Rgb) -> bool:
    return sum(abs(a - b) for a, b in zip(one, other, strict=True)) < _UNLIKE


def legible(color: Rgb) -> Rgb:
    """A colour made light or dark enough to be seen on any ground."""
    red, green, blue = color
    luminance = 0.299 * red + 0.587 * green + 0.114 * blue  # ITU-R BT.601
    if luminance > _LIGHTEST:
        share = _LIGHTEST / luminance
        return round(red * share), round(green * share), round(blue * share)
    if luminance < _DARKEST:
        added = round(_DARKEST - luminance)
        return min(255, red + added), min(255, green + added), min(255, blue + added)
    return color
