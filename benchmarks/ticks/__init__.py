"""One tick of a controller, in this library and in others, on the same motion."""
