"""Plain loops that write rows, compiled; the interpreter's overhead would be most of a tick."""
