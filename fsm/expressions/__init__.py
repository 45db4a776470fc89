"""Expressions and literals: parsed, typed and compiled to functions when a mission is loaded."""
