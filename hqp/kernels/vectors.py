"""Code of whole lines of numbers, written for LLVM as vectors.

A *line* is PAD numbers. LLVM, left to itself, makes loops that serve rows of any length: it tests for that at the start
of each, does what is left over one by one, and adds up the entries of one vector at the end of each sum. Here *tiles*
of rows, or of lines, are worked on side by side, so that no step waits for the one before, and the sums of a tile of
rows are added up at once. Machines with shorter vectors take several for a line.
"""

from __future__ import annotations

from dataclasses import dataclass
from inspect import Parameter, Signature, signature
from typing import Any

from llvmlite import ir
from numba import types
from numba.core.cgutils import alloca_once, for_range_slice, get_or_insert_function
from numba.extending import intrinsic
from numba.np.arrayobj import make_array

from .compile import FAST, INTERPRETED
from .layout import PAD

#: How many rows, or lines, are worked on side by side: as many as there are, then what is left.
TILES = (4, 2, 1)
#: Bytes of a number, by which lines are aligned at least.
SIZE = 8
#: The kinds of values, and how sums may be reordered: products are not made quotients.
LONG, NUMBER, LINE = ir.IntType(64), ir.DoubleType(), ir.VectorType(ir.DoubleType(), PAD)
SUMS, PRODUCTS = tuple(sorted(FAST)), ("contract", "nsz")


@dataclass(frozen=True)
class Numbers:
    """An array in memory, or a row of it: where it begins, and how many columns it has."""

    builder: Any
    begin: Any
    columns: Any = None

    def row(self, number):
        """One of its rows."""
        return Numbers(self.builder, self.at(self.builder.mul(self.columns, number)))

    def at(self, place):
        """Where this entry is."""
        return self.builder.gep(self.begin, [place])

    def entry(self, place):
        """This entry."""
        return self.builder.load(self.at(place))

    def line(self, first):
        """The line that begins with this entry."""
        return self.builder.load(self.builder.bitcast(self.at(first), LINE.as_pointer()), align=SIZE)

    def some(self, first, which):
        """The line that begins with this entry, of which nothing is read but those; zeros in place of others."""
        pointer, flags = LINE.as_pointer(), ir.VectorType(ir.IntType(1), PAD)
        kind = ir.FunctionType(LINE, [pointer, ir.IntType(32), flags, LINE])
        load = get_or_insert_function(self.builder.module, kind, f"llvm.masked.load.v{PAD}f64.p0v{PAD}f64")
        begin = self.builder.bitcast(self.at(first), pointer)
        return self.builder.call(load, [begin, ir.IntType(32)(SIZE), which, ir.Constant(LINE, None)])

    def write(self, first, values):
        """Write a vector from this entry on."""
        self.builder.store(values, self.builder.bitcast(self.at(first), values.type.as_pointer()), align=SIZE)


class Writer:
    """Writes the code."""

    def __init__(self, builder):
        self.builder = builder

    def tiles(self, first, end, unit=1, sizes=TILES):
        """Loops over first .. end in steps of `unit` times each of these sizes: the size, and the places in a step."""
        for size in sizes:
            whole = self.builder.and_(self.builder.sub(end, first), LONG(-unit * size))
            stop = self.builder.add(first, whole)
            with for_range_slice(self.builder, first, stop, LONG(unit * size), LONG) as (place, _):
                yield [self.builder.add(place, LONG(unit * k)) for k in range(size)]
            first = stop

    def lines(self, count, sizes):
        """The same over the lines of so many numbers."""
        return self.tiles(LONG(0), count, PAD, sizes)

    def sums(self, count):
        """So many lines that change, all zeros."""
        made = [alloca_once(self.builder, LINE) for _ in range(count)]
        for one in made:
            self.builder.store(ir.Constant(LINE, None), one)
        return made

    def add(self, sum_, value):
        """Add to a line that changes."""
        self.builder.store(self.plus(self.builder.load(sum_), value), sum_)

    def plus(self, one, other):
        """The sum of two values."""
        return self.builder.fadd(one, other, flags=SUMS)

    def minus(self, one, other):
        """Their difference."""
        return self.builder.fsub(one, other, flags=SUMS)

    def times(self, one, other):
        """Their product."""
        return self.builder.fmul(one, other, flags=PRODUCTS)

    def root(self, values):
        """The square root of each entry."""
        return self._by("sqrt", values)

    def roots(self, *squares):
        """The square roots of some numbers, found at once, with the signs of these."""
        kind = ir.VectorType(NUMBER, len(squares))
        together = ir.Constant(kind, ir.Undefined)
        for k, square in enumerate(squares):
            together = self.builder.insert_element(together, square, self._index(k))
        size = self._by("fabs", together)
        found = self._by("copysign", self.root(size), together)
        return [self.number(found, k) for k in range(len(squares))]

    def _by(self, name, *vectors):
        """What LLVM has of this name for such vectors."""
        kind = vectors[0].type
        function = ir.FunctionType(kind, [kind] * len(vectors))
        name = f"llvm.{name}.v{kind.count}f64"
        return self.builder.call(get_or_insert_function(self.builder.module, function, name), vectors)

    def everywhere(self, number, kind=LINE):
        """A line of one number."""
        one = self.builder.insert_element(ir.Constant(kind, ir.Undefined), number, self._index(0))
        return self._pick(one, one, [0] * PAD)

    def last(self, count):
        """Which entries of a line are its last ones, so many."""
        kind = ir.VectorType(LONG, PAD)
        first = self.everywhere(self.builder.sub(LONG(PAD), count), kind)
        return self.builder.icmp_signed(">=", ir.Constant(kind, list(range(PAD))), first)

    def first(self, count):
        """Which entries of a line are its first ones, so many."""
        kind = ir.VectorType(LONG, PAD)
        return self.builder.icmp_signed("<", ir.Constant(kind, list(range(PAD))), self.everywhere(count, kind))

    def among(self, which, values):
        """These entries of a line, and zeros in place of others."""
        return self.builder.select(which, values, ir.Constant(LINE, None))

    def number(self, values, place):
        """One entry of a vector."""
        return self.builder.extract_element(values, self._index(place))

    def together(self, lines):
        """The sum of lines that change."""
        found = [self.builder.load(one) for one in lines]
        while len(found) > 1:
            found = [self.plus(*pair) for pair in zip(found[::2], found[1::2], strict=True)]
        return found[0]

    def totals(self, lines):
        """A vector with the sum of the entries of each of some lines, a power of 2 of them."""
        groups = 1
        while len(lines) > 1:
            even = [p + q * PAD for g in range(0, PAD, 2 * groups) for q in (0, 1) for p in range(g, g + groups)]
            odd = [place + groups for place in even]
            pairs = zip(lines[::2], lines[1::2], strict=True)
            lines = [self.plus(self._pick(*pair, even), self._pick(*pair, odd)) for pair in pairs]
            groups *= 2
        (found,), length = lines, PAD
        while length > groups:
            length //= 2
            low, high = range(length), range(length, 2 * length)
            found = self.plus(self._pick(found, found, low), self._pick(found, found, high))
        return found

    def total(self, lines):
        """The sum of all entries of lines that change."""
        return self.number(self.totals([self.together(lines)]), 0)

    def _pick(self, one, other, places):
        """Entries of two vectors, which are counted through."""
        which = ir.Constant(ir.VectorType(ir.IntType(32), len(places)), list(places))
        return self.builder.shuffle_vector(one, other, which)

    @staticmethod
    def _index(place):
        return ir.Constant(ir.IntType(32), place)


def written(code, returns=types.void):
    """Decorator: `code`, called with a :class:`Writer` and the arguments, writes what a function of arrays does.

    The function itself is what the interpreter runs. Arguments are arrays, integers and floats.
    """

    def decorate(function):
        if INTERPRETED:
            return function

        def kind_of(argument):
            if isinstance(argument, types.Array):
                return argument
            return types.int64 if isinstance(types.unliteral(argument), types.Integer) else types.float64

        def define(typing, *arguments):
            def build(context, builder, kinds, values):
                given = []
                for kind, value in zip(kinds.args, values, strict=True):
                    if isinstance(kind, types.Array):
                        array = make_array(kind)(context, builder, value)
                        columns = builder.extract_value(array.shape, kind.ndim - 1)
                        value = Numbers(builder, array.data, columns)
                    given.append(value)
                found = code(Writer(builder), *given)
                return context.get_dummy_value() if found is None else found

            return returns(*map(kind_of, arguments)), build

        own = signature(function).parameters.values()
        define.__signature__ = Signature([Parameter("typing", Parameter.POSITIONAL_OR_KEYWORD), *own])
        define.__name__, define.__doc__ = function.__name__, function.__doc__
        made = intrinsic(define)
        made.py_func = function
        return made

    return decorate
