"""Graphs for people to look at: as text, as diagrams, in Mermaid's and Graphviz' languages."""

from fsm.drawing.diagram import Box, Diagram, Label, Line
from fsm.drawing.dot import write_dot
from fsm.drawing.layout import draw
from fsm.drawing.mermaid import write_mermaid
from fsm.drawing.outline import write_text
from fsm.drawing.svg import render, write_svg

__all__ = [
    "Box",
    "Diagram",
    "Label",
    "Line",
    "draw",
    "render",
    "write_dot",
    "write_mermaid",
    "write_svg",
    "write_text",
]
