"""What libraries of robots with a fixed base have in common here: joints in an order of their own."""

import numpy as np


class Joints:
    """A library at work.

    Attributes
    ----------
    columns : list of int
        Where it has the joints of the motion.
    """

    def configured(self, rows):
        """Numbers of the joints, of which there may be one row a tick, in the order of the library."""
        ordered = np.zeros_like(rows)
        ordered[..., self.columns] = rows
        return ordered

    def ordered(self, step):
        """In the order of the motion."""
        return [*step[self.columns]]

    def prepare(self, k):
        """What is not timed: nothing."""

    def split(self, k):
        """Its parts are not told."""
        return [None] * 3
