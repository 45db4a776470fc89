"""Graphs for people to look at: as text, as pictures, in Mermaid's and Graphviz' languages."""

from fsm.drawing.dot import write_dot
from fsm.drawing.layout import draw
from fsm.drawing.mermaid import write_mermaid
from fsm.drawing.outline import write_text
from fsm.drawing.picture import Box, Label, Line, Picture
from fsm.drawing.svg import render, write_svg

__all__ = [
    "Box",
    "Label",
    "Line",
    "Picture",
    "draw",
    "render",
    "write_dot",
    "write_mermaid",
    "write_svg",
    "write_text",
]
