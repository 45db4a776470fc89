"""From the spec of a mission to a compiled graph."""
