"""Sums over rows of whole lines of numbers, as vectors: the loops in which a solve spends most of its time.

A *line* is PAD numbers. The rows here end in zeros up to a whole line (:func:`.orthogonal.padded`). LLVM would make
loops over their entries that also serve other rows, and of any length, test for that at every start, and add up the
entries of one vector at the end of each sum. Here *tiles* of rows, or of lines, are worked on side by side, so that no
step waits for the one before; and the sums of a tile of rows are added up at once.
"""

from __future__ import annotations

import math

from llvmlite import ir
from numba import types
from numba.core.cgutils import alloca_once, for_range_slice, get_or_insert_function
from numba.extending import intrinsic
from numba.np.arrayobj import make_array

from .compile import FAST, INTERPRETED
from .layout import PAD

#: Rows, or lines, that are worked on side by side: as many as there are, then what is left.
TILES = (4, 2, 1)
#: Sums side by side for each line of a tile, so that one step need not wait for the one before.
SUMS = {4: 2, 2: 4, 1: 4}
#: Bytes of a number.
SIZE = 8

LONG, NUMBER, LINE = ir.IntType(64), ir.DoubleType(), ir.VectorType(ir.DoubleType(), PAD)
FLAGS = tuple(sorted(FAST))


class Writer:
    """Writes such loops in the language of LLVM."""

    def __init__(self, context, builder, signature, arguments):
        self.builder = builder
        self._arrays = {
            place: make_array(kind)(context, builder, value)
            for place, (kind, value) in enumerate(zip(signature.args, arguments, strict=True))
            if isinstance(kind, types.Array)
        }

    def data(self, place):
        """Where the array begins that is this argument."""
        return self._arrays[place].data

    def row(self, place, number):
        """Where this row of an array of two axes begins."""
        columns = self.builder.extract_value(self._arrays[place].shape, 1)
        return self.builder.gep(self.data(place), [self.builder.mul(columns, number)])

    def _line(self, row, first, kind):
        return self.builder.bitcast(self.builder.gep(row, [first]), kind.as_pointer())

    def load(self, row, first):
        """The line of a row that begins with its entry `first`."""
        return self.builder.load(self._line(row, first, LINE), align=SIZE)

    def store(self, value, row, first):
        """Write a vector to a row, from its entry `first` on."""
        self.builder.store(value, self._line(row, first, value.type), align=SIZE)

    def everywhere(self, number):
        """A line of one number."""
        one = self.builder.insert_element(ir.Constant(LINE, ir.Undefined), number, ir.Constant(ir.IntType(32), 0))
        return self.pick(one, one, [0] * PAD)

    def pick(self, one, other, places):
        """Entries of two vectors, which are counted through."""
        return self.builder.shuffle_vector(
            one, other, ir.Constant(ir.VectorType(ir.IntType(32), len(places)), list(places))
        )

    def plus(self, one, other):
        """Their sum."""
        return self.builder.fadd(one, other, flags=FLAGS)

    def minus(self, one, other):
        """Their difference."""
        return self.builder.fsub(one, other, flags=FLAGS)

    def times(self, one, other):
        """Their product, entry by entry."""
        return self.builder.fmul(one, other, flags=("contract", "nsz"))

    def root(self, values):
        """The square root of each entry of a vector."""
        kind = values.type
        find = get_or_insert_function(
            self.builder.module, ir.FunctionType(kind, [kind]), f"llvm.sqrt.v{kind.count}f64"
        )
        return self.builder.call(find, [values])

    def entry(self, place, number):
        """This entry of an array of one axis."""
        return self.builder.load(self.builder.gep(self.data(place), [number]))

    def both(self, one, other):
        """The sum of two lines that change."""
        return self.plus(self.builder.load(one), self.builder.load(other))

    def variables(self, count):
        """So many lines that change, all zeros."""
        made = [alloca_once(self.builder, LINE) for _ in range(count)]
        for one in made:
            self.builder.store(ir.Constant(LINE, None), one)
        return made

    def change(self, variable, how, value):
        """Set a line to what `how` makes of it and a value."""
        self.builder.store(how(self.builder.load(variable), value), variable)

    def tiles(self, first, end, unit, sizes=TILES):
        """Loops over first .. end in steps of `unit` times each of these sizes: yields each, and the place in it."""
        for size in sizes:
            whole = self.builder.and_(self.builder.sub(end, first), LONG(-unit * size))
            stop = self.builder.add(first, whole)
            with for_range_slice(self.builder, first, stop, LONG(unit * size), LONG) as (place, _):
                yield size, place
            first = stop

    def step(self, place, by):
        """`by` more."""
        return self.builder.add(place, LONG(by))

    def added(self, lines):
        """The sums of some lines, a power of 2, as a vector with an entry for each."""
        groups = 1
        while len(lines) > 1:
            made = []
            for one, other in zip(lines[::2], lines[1::2], strict=True):
                even = [p + q * PAD for g in range(0, PAD, 2 * groups) for q in (0, 1) for p in range(g, g + groups)]
                made.append(self.plus(self.pick(one, other, even), self.pick(one, other, [p + groups for p in even])))
            lines, groups = made, 2 * groups
        (found,), length = lines, PAD
        while length > groups:
            length //= 2
            low, high = range(length), range(length, 2 * length)
            found = self.plus(self.pick(found, found, low), self.pick(found, found, high))
        return found

    def last(self, count):
        """Which entries of a line are its last ones, so many."""
        numbers = ir.VectorType(LONG, PAD)
        at_least = self.builder.insert_element(
            ir.Constant(numbers, ir.Undefined), self.builder.sub(LONG(PAD), count), ir.Constant(ir.IntType(32), 0)
        )
        return self.builder.icmp_signed(
            ">=", ir.Constant(numbers, list(range(PAD))), self.pick(at_least, at_least, [0] * PAD)
        )

    def total(self, lines):
        """The sum of all entries of some lines, a power of 2."""
        while len(lines) > 1:
            lines = [self.plus(one, other) for one, other in zip(lines[::2], lines[1::2], strict=True)]
        return self.builder.extract_element(self.added(lines), ir.Constant(ir.IntType(32), 0))


def _writes(signature, build):
    """What an intrinsic returns: its signature, and `build` with a :class:`Writer` in place of the builder."""

    def code(context, builder, signature, arguments):
        value = build(Writer(context, builder, signature, arguments), *arguments)
        return context.get_dummy_value() if value is None else value

    return signature, code


@intrinsic
def multiply_lines(typing, rows, first, end, x, wide, out):
    """Write the products of rows[first:end] with x[:wide] to out[first:end]."""

    def build(write, rows, first, end, x, wide, out):
        for many, q in write.tiles(first, end, 1):
            mine, sums = [write.row(0, write.step(q, k)) for k in range(many)], write.variables(many)
            for _, t in write.tiles(LONG(0), wide, PAD, (1,)):
                entries = write.load(write.data(3), t)
                for row, one in zip(mine, sums, strict=True):
                    write.change(one, write.plus, write.times(write.load(row, t), entries))
            write.store(write.added([write.builder.load(one) for one in sums]), write.data(5), q)

    return _writes(types.void(rows, types.int64, types.int64, x, types.int64, out), build)


def _sum_of_rows(signature, sign):
    """Code of ``row[:wide] +- shares[first:end] rows[first:end]``."""

    def build(write, rows, first, end, shares, wide, row):
        how = getattr(write, sign)
        for many, t in write.tiles(LONG(0), wide, PAD):
            sets = SUMS[many]
            places, sums = [write.step(t, PAD * k) for k in range(many)], write.variables(many * sets)
            for place, one in zip(places, sums, strict=False):
                write.builder.store(write.load(write.data(5), place), one)
            for side, q in write.tiles(first, end, 1, (sets, 1)):
                for s in range(side):
                    number = write.step(q, s)
                    share = write.everywhere(write.builder.load(write.builder.gep(write.data(3), [number])))
                    mine = write.row(0, number)
                    for k in range(many):
                        write.change(sums[s * many + k], how, write.times(write.load(mine, places[k]), share))
            for k in range(many):
                parts = [write.builder.load(one) for one in sums[k::many]]
                while len(parts) > 1:
                    parts = [write.plus(a, b) for a, b in zip(parts[::2], parts[1::2], strict=True)]
                write.store(parts[0], write.data(5), places[k])

    return _writes(signature, build)


@intrinsic
def add_lines(typing, rows, first, end, shares, wide, row):
    """Add the rows first .. end - 1, each times its share, to row[:wide]."""
    return _sum_of_rows(types.void(rows, types.int64, types.int64, shares, types.int64, row), "plus")


@intrinsic
def subtract_lines(typing, rows, first, end, shares, wide, row):
    """Subtract the rows first .. end - 1, each times its share, from row[:wide]."""
    return _sum_of_rows(types.void(rows, types.int64, types.int64, shares, types.int64, row), "minus")


@intrinsic
def scale_line(typing, row, share, wide, out):
    """Write row[:wide], times a share, to out."""

    def build(write, row, share, wide, out):
        all_over = write.everywhere(share)
        for _, t in write.tiles(LONG(0), wide, PAD, (1,)):
            write.store(write.times(write.load(write.data(0), t), all_over), write.data(3), t)

    return _writes(types.void(row, types.float64, types.int64, out), build)


@intrinsic
def take_out(typing, rows, slots, first, count, direction, wide, parts, ids, column, sizes):
    """Subtract from the rows ``slots`` first .. count - 1 their parts along a unit vector, and write what is left.

    The parts go to this column of `parts`, each to the row that is its number in ``ids``; the lengths to `sizes`.
    """

    def build(write, rows, slots, first, count, direction, wide, parts, ids, column, sizes):
        builder, unit = write.builder, write.data(4)
        for many, r in write.tiles(first, count, 1):
            mine = [write.row(0, write.entry(1, write.step(r, k))) for k in range(many)]
            sums, squares = write.variables(2 * many), write.variables(2 * many)
            for side, t in write.tiles(LONG(0), wide, PAD, (2, 1)):
                for s in range(side):
                    place = write.step(t, PAD * s)
                    entries = write.load(unit, place)
                    for row, one in zip(mine, sums[s::2], strict=True):
                        write.change(one, write.plus, write.times(write.load(row, place), entries))
            along = write.added([write.both(*sums[2 * k : 2 * k + 2]) for k in range(many)])
            shares = []
            for k in range(many):
                share = builder.extract_element(along, ir.Constant(ir.IntType(32), k))
                shares.append(write.everywhere(share))
                into = write.row(6, write.entry(7, write.step(r, k)))
                builder.store(share, builder.gep(into, [column]))
            for side, t in write.tiles(LONG(0), wide, PAD, (2, 1)):
                for s in range(side):
                    place = write.step(t, PAD * s)
                    entries = write.load(unit, place)
                    for row, one, share in zip(mine, squares[s::2], shares, strict=True):
                        left = write.minus(write.load(row, place), write.times(entries, share))
                        write.store(left, row, place)
                        write.change(one, write.plus, write.times(left, left))
            left = write.added([write.both(*squares[2 * k : 2 * k + 2]) for k in range(many)])
            write.store(write.root(left), write.data(9), r)

    given = (rows, slots, types.int64, types.int64, direction, types.int64, parts, ids, types.int64, sizes)
    return _writes(types.void(*given), build)


@intrinsic
def product(typing, row, x, count):
    """The product of row[:count] with x[:count], of any length."""

    def build(write, row, x, count):
        mine, other, sums = write.data(0), write.data(1), write.variables(2)
        for many, t in write.tiles(LONG(0), count, PAD, (2, 1)):
            for k in range(many):
                place = write.step(t, PAD * k)
                write.change(sums[k], write.plus, write.times(write.load(mine, place), write.load(other, place)))
        builder, over = write.builder, write.builder.and_(count, LONG(PAD - 1))
        rest = alloca_once(builder, NUMBER)
        builder.store(NUMBER(0.0), rest)
        long = builder.icmp_signed(">=", count, LONG(PAD))
        with builder.if_then(builder.and_(long, builder.icmp_signed("!=", over, LONG(0)))):
            place = builder.sub(count, LONG(PAD))  # the last whole line: what overlaps counts once
            both = write.times(write.load(mine, place), write.load(other, place))
            write.change(sums[0], write.plus, builder.select(write.last(over), both, ir.Constant(LINE, None)))
        with builder.if_then(builder.not_(long)), for_range_slice(builder, LONG(0), count, LONG(1), LONG) as (t, _):
            one, two = (builder.load(builder.gep(data, [t])) for data in (mine, other))
            builder.store(write.plus(builder.load(rest), write.times(one, two)), rest)
        return write.plus(builder.load(rest), write.total([builder.load(one) for one in sums]))

    return _writes(types.float64(row, x, types.int64), build)


@intrinsic
def weigh(typing, row, weight, count, out):
    """Write row[:count], times a weight, to out; returns the square of the length of the row."""

    def build(write, row, weight, count, out):
        mine, into, sums, weights = write.data(0), write.data(3), write.variables(2), write.everywhere(weight)
        for many, t in write.tiles(LONG(0), count, PAD, (2, 1)):
            for k in range(many):
                place = write.step(t, PAD * k)
                entries = write.load(mine, place)
                write.store(write.times(entries, weights), into, place)
                write.change(sums[k], write.plus, write.times(entries, entries))
        builder, over = write.builder, write.builder.and_(count, LONG(PAD - 1))
        rest = alloca_once(builder, NUMBER)
        builder.store(NUMBER(0.0), rest)
        long = builder.icmp_signed(">=", count, LONG(PAD))
        with builder.if_then(builder.and_(long, builder.icmp_signed("!=", over, LONG(0)))):
            place = builder.sub(count, LONG(PAD))
            entries = write.load(mine, place)
            write.store(write.times(entries, weights), into, place)
            squares = builder.select(write.last(over), write.times(entries, entries), ir.Constant(LINE, None))
            write.change(sums[0], write.plus, squares)
        with builder.if_then(builder.not_(long)), for_range_slice(builder, LONG(0), count, LONG(1), LONG) as (t, _):
            one = builder.load(builder.gep(mine, [t]))
            builder.store(write.times(one, weight), builder.gep(into, [t]))
            builder.store(write.plus(builder.load(rest), write.times(one, one)), rest)
        return write.plus(builder.load(rest), write.total([builder.load(one) for one in sums]))

    return _writes(types.float64(row, types.float64, types.int64, out), build)


@intrinsic
def pick_entries(typing, row, places, wide, out):
    """Write the entries of a row at these places to out[:wide]."""

    def build(write, row, places, wide, out):
        builder = write.builder
        for _, t in write.tiles(LONG(0), wide, PAD, (1,)):
            made = ir.Constant(LINE, ir.Undefined)
            for k in range(PAD):
                place = builder.load(builder.gep(write.data(1), [write.step(t, k)]))
                entry = builder.load(builder.gep(write.data(0), [place]))
                made = builder.insert_element(made, entry, ir.Constant(ir.IntType(32), k))
            write.store(made, write.data(3), t)

    return _writes(types.void(row, places, types.int64, out), build)


if INTERPRETED:

    def product(row, x, count):
        return sum(row[t] * x[t] for t in range(count))

    def weigh(row, weight, count, out):
        for t in range(count):
            out[t] = weight * row[t]
        return sum(row[t] * row[t] for t in range(count))

    def pick_entries(row, places, wide, out):
        for t in range(wide):
            out[t] = row[places[t]]

    def multiply_lines(rows, first, end, x, wide, out):
        for q in range(first, end):
            out[q] = sum(rows[q][t] * x[t] for t in range(wide))

    def add_lines(rows, first, end, shares, wide, row):
        for q in range(first, end):
            for t in range(wide):
                row[t] += shares[q] * rows[q][t]

    def subtract_lines(rows, first, end, shares, wide, row):
        for q in range(first, end):
            for t in range(wide):
                row[t] -= shares[q] * rows[q][t]

    def scale_line(row, share, wide, out):
        for t in range(wide):
            out[t] = row[t] * share

    def take_out(rows, slots, first, count, direction, wide, parts, ids, column, sizes):
        for r in range(first, count):
            row = rows[slots[r]]
            along = parts[ids[r]][column] = sum(row[t] * direction[t] for t in range(wide))
            for t in range(wide):
                row[t] -= along * direction[t]
            sizes[r] = math.sqrt(sum(row[t] * row[t] for t in range(wide)))


if INTERPRETED:

    def product(row, x, count):
        return sum(row[t] * x[t] for t in range(count))

    def weigh(row, weight, count, out):
        for t in range(count):
            out[t] = weight * row[t]
        return sum(row[t] * row[t] for t in range(count))

    def pick_entries(row, places, wide, out):
        for t in range(wide):
            out[t] = row[places[t]]

    def multiply_lines(rows, first, end, x, wide, out):
        for q in range(first, end):
            out[q] = sum(rows[q][t] * x[t] for t in range(wide))

    def add_lines(rows, first, end, shares, wide, row):
        for q in range(first, end):
            for t in range(wide):
                row[t] += shares[q] * rows[q][t]

    def subtract_lines(rows, first, end, shares, wide, row):
        for q in range(first, end):
            for t in range(wide):
                row[t] -= shares[q] * rows[q][t]

    def scale_line(row, share, wide, out):
        for t in range(wide):
            out[t] = row[t] * share

    def take_out(row, direction, wide):
        along = sum(row[t] * direction[t] for t in range(wide))
        for t in range(wide):
            row[t] -= along * direction[t]
        return along, math.fsum(row[t] * row[t] for t in range(wide))
