"""What loops of contacts read and write: a slot, and a surface, each in one array."""

from __future__ import annotations

#: Of a slot: whether the contact is on; whether it bears, which ends as soon as it is being released; whether the place
#: where it holds has been taken.
ON, BEARS, TAKEN = range(3)
#: That place on its surface: where (3,), and the axes of the frame there (9, by rows).
PLACE, AXES = 3, 6
SLOT_SIZE = 15
#: Of a surface: where it is, its axes (by rows); its velocity, linear and angular, and its acceleration.
P, R, V, CHANGE = 0, 3, 12, 18
SURFACE_SIZE = 24
