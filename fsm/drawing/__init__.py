"""Graphs for people to look at: as text, in Mermaid's and Graphviz' languages."""

from fsm.drawing.dot import write_dot
from fsm.drawing.mermaid import write_mermaid
from fsm.drawing.outline import write_text

__all__ = ["write_dot", "write_mermaid", "write_text"]
