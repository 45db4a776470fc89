"""Compiles the spec of a mission to a graph."""
