"""Sums over the entries of rows, a line at a time: the loops in which a solve spends most of its time.

Each is what its function says in Python; :mod:`.vectors` tells how it is written. `wide` entries are whole lines: such
rows end in zeros (:func:`.layout.padded`). `count` entries may be any number.
"""

from __future__ import annotations

import math

from llvmlite import ir
from numba import types
from numba.core.cgutils import alloca_once, for_range_slice

from .layout import PAD
from .vectors import LINE, LONG, NUMBER, written

#: Sums side by side for each line of a tile, so that adding a row need not wait for the one before.
SIDE_BY_SIDE = {4: 2, 2: 4, 1: 4}


def add_products(write, rows, sums, x, wide):
    """Add the products of these rows with x[:wide], each to its own sum."""
    for (t,) in write.lines(wide, (1,)):
        entries = x.line(t)
        for row, one in zip(rows, sums, strict=True):
            write.add(one, write.times(row.line(t), entries))


def _products(write, rows, first, end, number_of, x, wide, out):
    """Write the products of rows first .. end - 1, which have these numbers, with x[:wide] to `out`."""
    for places in write.tiles(first, end):
        mine, sums = [rows.row(number_of(q)) for q in places], write.sums(len(places))
        add_products(write, mine, sums, x, wide)
        out.write(places[0], write.totals([write.together([one]) for one in sums]))


def _sum_of_rows(write, rows, first, end, number_of, shares, wide, row, sign, begin=None):
    """Change row[:wide], from `begin` on, by rows first .. end - 1, each times its share and `sign`."""
    for lines in write.tiles(LONG(0) if begin is None else begin, wide, PAD, (4, 2, 1)):
        many, sets = len(lines), SIDE_BY_SIDE[len(lines)]
        sums = write.sums(many * sets)
        for place, one in zip(lines, sums, strict=False):
            write.add(one, row.line(place))
        for places in write.tiles(first, end, sizes=(sets, 1)):
            for s, q in enumerate(places):
                share, mine = write.everywhere(write.times(shares.entry(q), NUMBER(sign))), rows.row(number_of(q))
                for place, one in zip(lines, sums[s * many : (s + 1) * many], strict=True):
                    write.add(one, write.times(mine.line(place), share))
        for k, place in enumerate(lines):
            row.write(place, write.together(sums[k::many]))


def _write_products_of_first(write, rows, count, x, n, out):
    builder = write.builder
    whole, over = builder.and_(n, LONG(-PAD)), builder.and_(n, LONG(PAD - 1))
    some, there = builder.icmp_signed("!=", over, LONG(0)), write.first(over)
    for places in write.tiles(LONG(0), count):
        mine, sums = [rows.row(q) for q in places], write.sums(len(places))
        add_products(write, mine, sums, x, whole)
        with builder.if_then(some):
            entries = x.some(whole, there)
            for row, one in zip(mine, sums, strict=True):
                terms = write.times(row.line(whole), entries)
                write.add(one, write.among(there, terms))
        out.write(places[0], write.totals([write.together([one]) for one in sums]))


@written(_write_products_of_first)
def multiply_first(rows, count, x, n, out):
    """Write the products of rows[:count], which have room for whole lines, with x[:n] to out[:count]."""
    for q in range(count):
        out[q] = sum(rows[q][t] * x[t] for t in range(n))


def _write_products(write, rows, first, end, x, wide, out):
    _products(write, rows, first, end, lambda q: q, x, wide, out)


@written(_write_products)
def multiply_lines(rows, first, end, x, wide, out):
    """Write the products of rows[first:end] with x[:wide] to out[first:end]."""
    for q in range(first, end):
        out[q] = sum(rows[q][t] * x[t] for t in range(wide))


def _write_products_of(write, rows, ids, count, x, wide, out):
    _products(write, rows, LONG(0), count, ids.entry, x, wide, out)


@written(_write_products_of)
def multiply_chosen(rows, ids, count, x, wide, out):
    """Write the products of the rows ids[:count] with x[:wide] to out[:count]."""
    for q in range(count):
        out[q] = sum(rows[ids[q]][t] * x[t] for t in range(wide))


def _write_sum(write, rows, first, end, shares, wide, row):
    _sum_of_rows(write, rows, first, end, lambda q: q, shares, wide, row, 1.0)


@written(_write_sum)
def add_lines(rows, first, end, shares, wide, row):
    """Add rows[first:end], each times its share, to row[:wide]."""
    for q in range(first, end):
        for t in range(wide):
            row[t] += shares[q] * rows[q][t]


def _write_sum_behind(write, rows, first, end, shares, begin, wide, row):
    _sum_of_rows(write, rows, first, end, lambda q: q, shares, wide, row, 1.0, write.builder.and_(begin, LONG(-PAD)))


@written(_write_sum_behind)
def add_lines_behind(rows, first, end, shares, begin, wide, row):
    """Add rows[first:end], each times its share, to row[:wide], from the line on in which entry `begin` is."""
    for q in range(first, end):
        for t in range(begin & -PAD, wide):
            row[t] += shares[q] * rows[q][t]


def _write_difference(write, rows, first, end, shares, wide, row):
    _sum_of_rows(write, rows, first, end, lambda q: q, shares, wide, row, -1.0)


@written(_write_difference)
def subtract_lines(rows, first, end, shares, wide, row):
    """Subtract rows[first:end], each times its share, from row[:wide]."""
    for q in range(first, end):
        for t in range(wide):
            row[t] -= shares[q] * rows[q][t]


def _write_difference_of(write, rows, ids, count, shares, wide, row):
    _sum_of_rows(write, rows, LONG(0), count, ids.entry, shares, wide, row, -1.0)


@written(_write_difference_of)
def subtract_chosen(rows, ids, count, shares, wide, row):
    """Subtract the rows ids[:count], each times its share, from row[:wide]."""
    for q in range(count):
        for t in range(wide):
            row[t] -= shares[q] * rows[ids[q]][t]


def _write_scaled(write, row, share, wide, out):
    all_over = write.everywhere(share)
    for (t,) in write.lines(wide, (1,)):
        out.write(t, write.times(row.line(t), all_over))


@written(_write_scaled)
def scale_line(row, share, wide, out):
    """Write row[:wide], times a share, to `out`."""
    for t in range(wide):
        out[t] = row[t] * share


def _take_out(write, rows, slots, first, count, direction, wide, parts, ids, column, sizes):
    for places in write.tiles(first, count):
        mine = [rows.row(slots.entry(r)) for r in places]
        sums, squares = write.sums(2 * len(mine)), write.sums(2 * len(mine))
        for lines in write.lines(wide, (2, 1)):
            for side, t in enumerate(lines):
                entries = direction.line(t)
                for row, one in zip(mine, sums[side::2], strict=True):
                    write.add(one, write.times(row.line(t), entries))
        along = write.totals([write.together(sums[2 * k : 2 * k + 2]) for k in range(len(mine))])
        numbers = [write.number(along, k) for k in range(len(mine))]
        for r, part in zip(places, numbers, strict=True):
            write.builder.store(part, parts.row(ids.entry(r)).at(column))
        shares = [write.everywhere(part) for part in numbers]
        for lines in write.lines(wide, (2, 1)):
            for side, t in enumerate(lines):
                entries = direction.line(t)
                for row, one, share in zip(mine, squares[side::2], shares, strict=True):
                    left = write.minus(row.line(t), write.times(entries, share))
                    row.write(t, left)
                    write.add(one, write.times(left, left))
        left = write.totals([write.together(squares[2 * k : 2 * k + 2]) for k in range(len(mine))])
        sizes.write(places[0], write.root(left))


@written(_take_out)
def take_out(rows, slots, first, count, direction, wide, parts, ids, column, sizes):
    """Subtract from the rows slots[first:count] their parts along a unit vector; the lengths left go to `sizes`.

    The parts go to this column of `parts`, each to the row that has its number in `ids`.
    """
    for r in range(first, count):
        row = rows[slots[r]]
        along = parts[ids[r]][column] = sum(row[t] * direction[t] for t in range(wide))
        for t in range(wide):
            row[t] -= along * direction[t]
        sizes[r] = math.sqrt(sum(row[t] * row[t] for t in range(wide)))


def _any_sum(write, count, line_at, entry_at):
    """The sum of `count` numbers, a line or one at a time; the last whole line overlaps the one before."""
    builder, sums, rest = write.builder, write.sums(2), alloca_once(write.builder, NUMBER)
    builder.store(NUMBER(0.0), rest)
    for places in write.lines(count, (2, 1)):
        for one, t in zip(sums, places, strict=False):
            write.add(one, line_at(t))
    over, long = builder.and_(count, LONG(PAD - 1)), builder.icmp_signed(">=", count, LONG(PAD))
    with builder.if_then(builder.and_(long, builder.icmp_signed("!=", over, LONG(0)))):
        values = line_at(builder.sub(count, LONG(PAD)))
        write.add(sums[0], builder.select(write.last(over), values, ir.Constant(LINE, None)))
    with builder.if_then(builder.not_(long)), for_range_slice(builder, LONG(0), count, LONG(1), LONG) as (t, _):
        builder.store(write.plus(builder.load(rest), entry_at(t)), rest)
    return write.plus(builder.load(rest), write.total(sums))


def _product(write, row, x, count):
    sums, whole = write.sums(2), write.builder.and_(count, LONG(-PAD))
    for places in write.lines(whole, (2, 1)):
        for one, t in zip(sums, places, strict=False):
            write.add(one, write.times(row.line(t), x.line(t)))
    there = write.first(write.builder.and_(count, LONG(PAD - 1)))
    write.add(sums[0], write.times(row.some(whole, there), x.some(whole, there)))
    return write.total(sums)


@written(_product, types.float64)
def product(row, x, count):
    """The product of row[:count] with x[:count]."""
    return sum(row[t] * x[t] for t in range(count))


def _weigh(write, row, weight, count, out):
    weights = write.everywhere(weight)

    def line_at(t):
        entries = row.line(t)
        out.write(t, write.times(entries, weights))
        return write.times(entries, entries)

    def entry_at(t):
        entry = row.entry(t)
        write.builder.store(write.times(entry, weight), out.at(t))
        return write.times(entry, entry)

    return _any_sum(write, count, line_at, entry_at)


@written(_weigh, types.float64)
def weigh(row, weight, count, out):
    """Write row[:count], times a weight, to `out`; returns the square of the length of the row."""
    for t in range(count):
        out[t] = weight * row[t]
    return sum(row[t] * row[t] for t in range(count))


def _pick_entries(write, row, places, wide, out):
    for (t,) in write.lines(wide, (1,)):
        made = ir.Constant(LINE, ir.Undefined)
        for k in range(PAD):
            entry = row.entry(places.entry(write.builder.add(t, LONG(k))))
            made = write.builder.insert_element(made, entry, ir.Constant(ir.IntType(32), k))
        out.write(t, made)


@written(_pick_entries)
def pick_entries(row, places, wide, out):
    """Write the entries of a row at these places to out[:wide]."""
    for t in range(wide):
        out[t] = row[places[t]]


def _add_to_lines(write, rows, count, shares, x, wide):
    for (t,) in write.lines(wide, (1,)):
        entries = x.line(t)
        for (r,) in write.tiles(LONG(0), count, sizes=(1,)):
            row = rows.row(r)
            row.write(t, write.plus(row.line(t), write.times(entries, write.everywhere(shares.entry(r)))))


@written(_add_to_lines)
def add_to_lines(rows, count, shares, x, wide):
    """Add x[:wide], times its share, to each of rows[:count]."""
    for r in range(count):
        for t in range(wide):
            rows[r][t] += shares[r] * x[t]


def _scale_behind(write, row, share, begin, wide, out):
    builder, all_over, none = write.builder, write.everywhere(share), ir.Constant(LINE, None)
    place = builder.and_(begin, LONG(-PAD))
    for (t,) in write.lines(place, (1,)):
        out.write(t, none)
    before = write.first(builder.and_(begin, LONG(PAD - 1)))
    with builder.if_then(builder.icmp_signed("<", place, wide)):
        out.write(place, builder.select(before, none, write.times(row.line(place), all_over)))
    for (t,) in write.tiles(builder.add(place, LONG(PAD)), wide, PAD, (1,)):
        out.write(t, write.times(row.line(t), all_over))


@written(_scale_behind)
def scale_behind(row, share, begin, wide, out):
    """Write row[begin:wide], times a share, to `out`, and zeros before."""
    for t in range(wide):
        out[t] = row[t] * share if t >= begin else 0.0
