"""The picture of a run, drawn from its folder."""

from cli.plot.flight import NAME, draw

__all__ = ["NAME", "draw"]
