"""The checks that a compiled graph must pass before it may fly."""
