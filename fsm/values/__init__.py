"""Values of missions: their types, the functions of expressions, conversion and JSON."""
