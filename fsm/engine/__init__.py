"""Running a graph: the interpreter, its running state, and saving it."""
