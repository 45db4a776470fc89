"""Upper estimates of the width of texts, for any of the usual sans-serif fonts."""

from __future__ import annotations

# Advances in hundredths of the font size: DejaVu Sans and its bold, as wide as such fonts get.
_REGULAR = {
    30: "'ijlIJ",
    35: " ,./:;\\|f",
    42: "-()[]t!r",
    56: '"*_`sz?c',
    61: "LFkvxyPTYao",
    66: "eESbdghnpqu$0123456789{}K",
    78: "AVBRXZCUHNDG&",
    88: "OQw#+<=>^~M",
    101: "%mW@",
}
_WIDTHS = {letter: width for width, letters in _REGULAR.items() for letter in letters}
_OTHER = 101
_BOLD = 1.26


def text_width(text: str, size: float, bold: bool = False) -> float:
    """An upper estimate of a text's width, in the unit of its font size."""
    hundredths = sum(_WIDTHS.get(letter, _OTHER) for letter in text)
    return hundredths * size / 100 * (_BOLD if bold else 1.0) + 1.0
