"""What loops of contacts read and write: a slot, and a surface, each in one array."""

from __future__ import annotations

#: Of a slot: whether the motion is forbidden; whether there may be forces; whether it is one to rely on, which ends as
#: soon as it is being released; whether the place where it holds has been taken; how far the motion is let off
#: [m/s^2], [rad/s^2].
ON, LOADED, BEARS, TAKEN, OPEN = range(5)
#: That place on its surface: where (3,), and the axes of the frame there (9, by rows).
PLACE, AXES = 5, 8
SLOT_SIZE = 17
#: Of a surface: where it is, its axes (by rows); its velocity, linear and angular, and its acceleration.
P, R, V, CHANGE = 0, 3, 12, 18
SURFACE_SIZE = 24
