"""The picture of a run, drawn from its folder."""

from cli.plot.flight import draw

__all__ = ["draw"]
