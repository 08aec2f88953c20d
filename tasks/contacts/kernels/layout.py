"""The arrays that loops of contacts share: the slot of a contact, which is its state, and a surface."""

from __future__ import annotations

#: Slot: 1 if the motion is forbidden; if there may be forces; if the contact counts as support, which ends when its
#: release begins; if the held pose was stored; by how much the rows of the motion are widened [m/s^2], [rad/s^2].
ON, LOADED, BEARS, TAKEN, OPEN = range(5)
#: The held pose, relative to the surface: position (3,) and rotation (9, by rows).
PLACE, AXES = 5, 8
#: The share of the forces that a ramp leaves, 1 without.
SHARE = 17
SLOT_SIZE = 18
#: Surface: position; rotation (by rows); velocity, linear and angular; acceleration, linear and angular.
P, R, V, CHANGE = 0, 3, 12, 18
SURFACE_SIZE = 24
