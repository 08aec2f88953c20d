r"""Soft ranges of joints, from the ``<safety_controller>`` of a URDF.

The safety controller of such a robot lets a joint at q move no faster than

.. math:: -k_p (q - q_\text{low}) \le \dot q \le -k_p (q - q_\text{high}),

with the ends of the soft range: it holds joints inside, whatever is commanded. So a soft range is the range of its
joint, as far as it lies in that of ``<limit>``. Neither gain is read: joint limits brake at their own rates.
"""

from __future__ import annotations

from collections.abc import Callable
from xml.etree.ElementTree import Element

from hqp import InvalidInput

#: Joint types that have a range.
RANGED = ("revolute", "prismatic")
#: Ends of a range: attribute of the limit, and of the safety controller.
ENDS = (("lower", "soft_lower_limit"), ("upper", "soft_upper_limit"))

#: The element that has a soft range.
SAFETY = "safety_controller"

#: Reads a number of an element, by its name, with a default, and what to call it in messages.
Number = Callable[[Element, str, str, str], float]


def narrow_ranges(joints: list[Element], number: Number, what: str) -> None:
    """Narrow the limits of joints to their soft ranges.

    An end that is not given, and a soft range from 0 to 0, mean none: URDF has 0 for what is missing.

    Raises
    ------
    InvalidInput
        If the ends of a soft range are in the wrong order or no numbers, or it lies outside the range of its joint.
    """
    for joint in joints:
        soft, limit = joint.find(SAFETY), joint.find("limit")
        if soft is None or limit is None or joint.get("type") not in RANGED:
            continue
        own = f"{what}: {SAFETY} of joint {joint.get('name')!r}"
        given = {end: number(soft, key, "0", own) for end, key in ENDS if key in soft.attrib}
        if not any(given.values()):
            continue
        hard = {end: number(limit, end, "0", f"{what}: limit of joint {joint.get('name')!r}") for end, _ in ENDS}
        low, high = given.get("lower", hard["lower"]), given.get("upper", hard["upper"])
        if low > high:
            raise InvalidInput(f"{own}: the soft range {low:g} .. {high:g} is empty")
        if any(hard.values()):  # a range from 0 to 0 means none
            low, high = max(low, hard["lower"]), min(high, hard["upper"])
        if low > high:
            raise InvalidInput(f"{own}: the soft range is outside the range {hard['lower']:g} .. {hard['upper']:g}")
        limit.set("lower", repr(low))
        limit.set("upper", repr(high))
