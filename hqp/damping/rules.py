r"""Damping rules: the lambda of a level, from the singular values of its projected rows or from its residual.

A damped level minimises, within what the levels above it leave,

.. math:: \|D_k w_k\|^2 + \lambda^2 \|x - x_\text{ref}\|^2,

see :mod:`hqp.damping.staged`. The :math:`\sigma_i` are the singular values of its *projected rows*
:math:`\hat J = D_k A_k Z`: its equality and active rows, weighted, in the null space Z of the equality
and active rows above. Active are the rows that are at a bound, or beyond it, where the levels above
leave off.

Whatever the rule and the posture, the damping bounds what the level adds to :math:`x_a`, the answer of the levels
above it. Let :math:`r_a = D_k w_k(x_a)` be what it lacks there, and g the largest :math:`\sigma / (\sigma^2 +
\lambda^2)`, see :meth:`DampingRule.largest_gain`; then, where all rows are equalities,

.. math:: \|x - x_a\| \le g \|r_a\|.

For a lambda that is fixed, or follows from :math:`r_a` alone, this holds among inequalities, too, with :math:`g = 1 / 2
\lambda`. Let :math:`d = x - x_a` and, for simplicity, :math:`x_\text{ref} = 0`. That x is optimal and :math:`x_a` the
shortest among convex choices means :math:`\langle A^T (A x - r) + \lambda^2 x, d \rangle \le 0` and
:math:`\langle x_a, d \rangle \ge 0`; hence :math:`\lambda^2 \|d\|^2 \le \|r_a\| \|A d\| - \|A d\|^2 \le
\|r_a\|^2 / 4`. A lambda of :math:`\|r_a\| / 2 b` therefore bounds d by b, whatever is lacking.
"""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from dataclasses import dataclass, fields
from typing import ClassVar

from ..arrays import Array
from ..checks import positive_number, real_number
from ..errors import InvalidInput
from ..hierarchy import LARGEST

#: What a number of this name may be though it is not positive and finite: nowhere a threshold, and no damping.
EXEMPT = {"threshold": math.inf, "least": 0.0}


@dataclass(frozen=True)
class DampingRule(ABC):
    """The base class of all rules; a subclass needs a `damping` of its own.

    Attributes
    ----------
    looks : bool
        Whether it uses the singular values; they cost one more stage if there are inequalities.
    mixes : bool
        Whether it damps a combination of rows (see `filtering`), which only equality rows permit.
    grows : bool
        Whether its lambda grows with the residual of the level (see `growth`), which costs one more stage if there are
        levels above it whose answer is not known already.

    Raises
    ------
    InvalidInput
        If a number is not positive, or not below 1e30; a threshold may be infinite, and a least damping 0.
    """

    looks: ClassVar[bool] = True
    mixes: ClassVar[bool] = False
    grows: ClassVar[bool] = False

    def __post_init__(self) -> None:
        for field in fields(self):
            value, what = getattr(self, field.name), f"{type(self).__name__}: {field.name}"
            if field.name not in EXEMPT or real_number(value, what) != EXEMPT[field.name]:
                value = positive_number(value, what, below=LARGEST)
            object.__setattr__(self, field.name, float(value))

    @abstractmethod
    def damping(self, singular: Array) -> float:
        """The lambda, given one singular value for each row, largest first; 0 leaves the level strict."""

    def filtering(self, singular: Array) -> float:
        """The beta by which the weakest combination of rows is damped beyond lambda."""
        return 0.0

    def growth(self, singular: Array) -> float:
        r"""The growth of lambda with the residual of the level: the c of :math:`\lambda^2 + c^2 \|r_a\|^2`."""
        return 0.0

    def largest_gain(self, rows: int, longest: float) -> float:
        r"""The largest :math:`\sigma_i / (\sigma_i^2 + \lambda^2)` under this rule.

        Parameters
        ----------
        rows : int
            How many singular values there are.
        longest : float
            The largest that one of them may be, in the unit of the weighted rows.

        Returns
        -------
        float
            In the inverse unit; infinite if the rule gives no bound.
        """
        return math.inf

    def largest_change(self, rows: int, longest: float, lacking: float) -> float:
        r"""The most that the level may add to x, :math:`\|x - x_a\|`.

        Parameters
        ----------
        rows, longest
            As for `largest_gain`.
        lacking : float
            Residual of the level at the answer of the levels above, :math:`\|r_a\|`.

        Returns
        -------
        float
            In the unit of x.
        """
        return self.largest_gain(rows, longest) * lacking if lacking > 0.0 else 0.0


@dataclass(frozen=True)
class FixedDamping(DampingRule):
    """The same lambda everywhere: the damped least squares of Wampler (1986).

    Parameters
    ----------
    factor : float
        The lambda, in the unit of the weighted rows.

    Examples
    --------
    >>> from hqp import FixedDamping, Hierarchy, Level, solve
    >>> flat = Hierarchy([Level.equality([[0.01, 0.0]], [1.0], name="flat")])
    >>> solve(flat).x, solve(flat, damping={"flat": FixedDamping(0.1)}).x.round(3)
    (array([100.,   0.]), array([0.99, 0.  ]))
    """

    looks: ClassVar[bool] = False
    factor: float

    def damping(self, singular: Array) -> float:
        return self.factor

    def largest_gain(self, rows: int, longest: float) -> float:
        r""":math:`1 / 2 \lambda`, at :math:`\sigma = \lambda`."""
        return 0.5 / self.factor


@dataclass(frozen=True)
class ManipulabilityDamping(DampingRule):
    r""":math:`\lambda = \lambda_0 (1 - w / w_0)` where the manipulability w is below :math:`w_0`, 0 elsewhere.

    :math:`w = \sqrt{\det \hat J \hat J^T} = \prod \sigma_i`, Nakamura and Hanafusa (1986). A level with more rows
    than there are unknowns left for it has w = 0.

    Parameters
    ----------
    largest : float
        :math:`\lambda_0`, the damping of a singular level.
    threshold : float
        :math:`w_0`.

    Examples
    --------
    >>> from hqp import Hierarchy, Level, ManipulabilityDamping, solve
    >>> flat = Hierarchy([Level.equality([[0.01, 0.0]], [1.0], name="flat")])
    >>> solve(flat).x, solve(flat, damping={"flat": ManipulabilityDamping(0.1, 0.05)}).x.round(3)
    (array([100.,   0.]), array([1.538, 0.   ]))
    """

    largest: float
    threshold: float

    def damping(self, singular: Array) -> float:
        w = math.prod(singular.tolist()) if len(singular) else math.inf
        return self.largest * max(1.0 - w / self.threshold, 0.0)

    def largest_gain(self, rows: int, longest: float) -> float:
        r""":math:`1 / 2 \lambda_0 + \sigma_1^{m-1} / w_0`.

        No :math:`\sigma_i` is below :math:`w / \sigma_1^{m-1}`, so with the share :math:`s = w / w_0` the gain is at
        most the smaller one of :math:`\sigma_1^{m-1} / s w_0` and :math:`1 / 2 \lambda_0 (1 - s)`; where they meet is
        the bound.
        """
        return 0.5 / self.largest + longest ** (rows - 1) / self.threshold


@dataclass(frozen=True)
class SingularValueDamping(DampingRule):
    r""":math:`\lambda^2 = \lambda_0^2 (1 - (\sigma / \epsilon)^2)` where the smallest singular value is below epsilon.

    Elsewhere 0; Maciejewski and Klein (1988), Chiaverini, Siciliano and Egeland (1994).

    Parameters
    ----------
    largest : float
        :math:`\lambda_0`, the damping of a singular level.
    threshold : float
        :math:`\epsilon`.

    Examples
    --------
    >>> from hqp import Hierarchy, Level, SingularValueDamping, solve
    >>> flat = Hierarchy([Level.equality([[0.01, 0.0]], [1.0], name="flat")])
    >>> solve(flat).x, solve(flat, damping={"flat": SingularValueDamping(0.1, 0.05)}).x.round(3)
    (array([100.,   0.]), array([1.031, 0.   ]))
    """

    largest: float
    threshold: float

    def damping(self, singular: Array) -> float:
        return self.largest * _fade(singular, self.threshold)

    def largest_gain(self, rows: int, longest: float) -> float:
        r""":math:`\sqrt{1 / (2 \lambda_0)^2 + 1 / \epsilon^2}`.

        With the share :math:`s = \sigma_\text{min} / \epsilon` the gain is at most the smaller one of
        :math:`1 / s \epsilon` and :math:`1 / 2 \lambda_0 \sqrt{1 - s^2}`; where they meet is the bound.
        """
        return math.hypot(0.5 / self.largest, 1.0 / self.threshold)


@dataclass(frozen=True)
class NumericalFiltering(DampingRule):
    r"""Little damping everywhere, more for the weakest combination of rows: :math:`\lambda^2 I + \beta^2 u u^T`.

    u is the left singular vector of the smallest singular value (Maciejewski and Klein 1988). It takes levels of
    equality rows, which alone can be combined.

    Parameters
    ----------
    factor : float
        The lambda.
    extra : float
        The beta.
    threshold : float, optional
        The smallest singular value below which beta sets in, as in :class:`SingularValueDamping` (default: always).

    Examples
    --------
    >>> from hqp import Hierarchy, Level, NumericalFiltering, solve
    >>> flat = Hierarchy([Level.equality([[1.0, 0.0], [0.0, 0.01]], [1.0, 1.0], name="flat")])
    >>> solve(flat).x, solve(flat, damping={"flat": NumericalFiltering(0.01, 0.1)}).x.round(3)
    (array([  1., 100.]), array([1.  , 0.98]))
    """

    mixes: ClassVar[bool] = True
    factor: float
    extra: float
    threshold: float = math.inf

    def damping(self, singular: Array) -> float:
        return self.factor

    def filtering(self, singular: Array) -> float:
        return self.extra * _fade(singular, self.threshold)

    def largest_gain(self, rows: int, longest: float) -> float:
        r""":math:`1 / 2 \lambda`: the filtering makes the gain of the weakest combination smaller still."""
        return 0.5 / self.factor


@dataclass(frozen=True)
class ErrorDamping(DampingRule):
    r"""Damping by the residual, :math:`\lambda^2 = \lambda_0^2 + \|r_a\|^2 / (2 b)^2`: it adds no more than b to x.

    Levenberg-Marquardt damping in a hierarchy, after Sugihara (2011), whose share of the square of the error is
    :math:`1 / 4 b^2`: weak if the residual is small, strong if it is large. It does not
    use singular values.

    Parameters
    ----------
    bound : float
        b, in the unit of x: [rad/s] at velocity order.
    least : float, optional
        :math:`\lambda_0`, in the unit of the weighted rows (default: 0). Alone, the part that grows fades where the
        error does: a level that is singular just where its error vanishes is held by this one.

    Notes
    -----
    :math:`\|x - x_a\| \le \|r_a\| / 2 \lambda \le b`, however the singular values and :math:`r_a` go to zero together.
    A lambda that is negligible beside the rank tolerance of :class:`hqp.Settings` counts as 0: the level is strict, and
    singular values as small count as zero.

    Examples
    --------
    >>> from hqp import ErrorDamping, Hierarchy, Level, solve
    >>> flat = Hierarchy([Level.equality([[0.01, 0.0]], [1.0], name="flat")])
    >>> solve(flat).x, solve(flat, damping={"flat": ErrorDamping(0.5)}).x.round(3)
    (array([100.,   0.]), array([0.01, 0.  ]))
    """

    looks: ClassVar[bool] = False
    grows: ClassVar[bool] = True
    bound: float
    least: float = 0.0

    def damping(self, singular: Array) -> float:
        return self.least

    def growth(self, singular: Array) -> float:
        return 0.5 / self.bound

    def largest_gain(self, rows: int, longest: float) -> float:
        r""":math:`1 / 2 \lambda_0`: that of a level with nearly no residual."""
        return 0.5 / self.least if self.least else math.inf

    def largest_change(self, rows: int, longest: float, lacking: float) -> float:
        r""":math:`\|r_a\| / 2 \lambda`, less than :math:`b` whatever is lacking; among inequalities, too."""
        return 0.5 * lacking / math.hypot(self.least, 0.5 * lacking / self.bound) if lacking > 0.0 else 0.0


def _fade(singular: Array, threshold: float) -> float:
    """From 1 where the smallest singular value is 0 to 0 where it reaches the threshold."""
    share = min(float(singular.min(initial=math.inf)) / threshold, 1.0) if len(singular) else 1.0
    return math.sqrt(1.0 - share * share)


def as_rule(value: object, what: str) -> DampingRule:
    """A rule as it is, a number as a :class:`FixedDamping`; InvalidInput that begins with `what` otherwise."""
    if isinstance(value, DampingRule):
        return value
    try:
        return FixedDamping(value)  # type: ignore[arg-type]
    except InvalidInput as error:
        raise InvalidInput(f"{what}: neither a rule nor a number for one ({error})") from None
