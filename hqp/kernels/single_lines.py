"""What loops do to single rows, and to matrices of rows of one line at most; written as in :mod:`.lines`."""

from __future__ import annotations

from llvmlite import ir

from .layout import PAD
from .vectors import LINE, LONG, written


def _write_products_of_line(write, rows, count, x, n, out):
    there = write.first(n)
    entries = x.some(LONG(0), there)
    for places in write.tiles(LONG(0), count):
        terms = [write.times(rows.row(q).line(LONG(0)), entries) for q in places]
        out.write(places[0], write.totals([write.among(there, each) for each in terms]))


@written(_write_products_of_line)
def multiply_line(rows, count, x, n, out):
    """As :func:`multiply_first` for rows of one line at most, x[:n]: with nothing to loop over in them."""
    for q in range(count):
        out[q] = sum(rows[q][t] * x[t] for t in range(n))


def _write_sum_of_line(write, shares, rows, first, end, out):
    (total,) = write.sums(1)
    write.add(total, out.line(LONG(0)))
    for (q,) in write.tiles(first, end, sizes=(1,)):
        write.add(total, write.times(rows.row(q).line(LONG(0)), write.everywhere(shares.entry(q))))
    out.write(LONG(0), write.together([total]))


@written(_write_sum_of_line)
def add_line(shares, rows, first, end, out):
    """Add the first line of rows[first:end], each times its share, to that of out."""
    for q in range(first, end):
        for t in range(PAD):
            out[t] += shares[q] * rows[q][t]


def _copy(write, row, wide, out):
    for (t,) in write.lines(wide, (1,)):
        out.write(t, row.line(t))


@written(_copy)
def copy_line(row, wide, out):
    """Write row[:wide] to `out`."""
    for t in range(wide):
        out[t] = row[t]


def _clear(write, row, wide):
    for (t,) in write.lines(wide, (1,)):
        row.write(t, ir.Constant(LINE, None))


@written(_clear)
def clear_line(row, wide):
    """Write zeros to row[:wide]."""
    for t in range(wide):
        row[t] = 0.0


def _add_scaled(write, row, share, wide, out):
    all_over = write.everywhere(share)
    for (t,) in write.lines(wide, (1,)):
        out.write(t, write.plus(out.line(t), write.times(row.line(t), all_over)))


@written(_add_scaled)
def add_scaled(row, share, wide, out):
    """Add row[:wide], times a share, to `out`."""
    for t in range(wide):
        out[t] += share * row[t]


def _eliminate(write, rows, j, end, over):
    none, own = LONG(0), rows.row(j)
    scaled = write.times(own.line(none), write.everywhere(over))
    for (r,) in write.tiles(write.builder.add(j, LONG(1)), end, sizes=(1,)):
        row = rows.row(r)
        row.write(none, write.minus(row.line(none), write.times(scaled, write.everywhere(own.entry(r)))))


@written(_eliminate)
def eliminate(rows, j, end, over):
    """Subtract row j, times its entry r and `over`, from each row r behind it: from the first line of rows[:end]."""
    for r in range(j + 1, end):
        for t in range(PAD):
            rows[r][t] -= over * rows[j][r] * rows[j][t]


def _reflect_below(write, rows, top, first, end, head, parts, scale, begin, wide):
    upper, (along,) = rows.row(top), write.sums(1)
    heads = write.everywhere(head)
    for (t,) in write.tiles(write.builder.and_(begin, LONG(-PAD)), wide, PAD, (1,)):
        write.builder.store(write.times(upper.line(t), heads), along)
        for (r,) in write.tiles(first, end, sizes=(1,)):
            write.add(along, write.times(rows.row(r).line(t), write.everywhere(parts.entry(r))))
        share = write.times(write.together([along]), write.everywhere(scale))
        upper.write(t, write.minus(upper.line(t), write.times(share, heads)))
        for (r,) in write.tiles(first, end, sizes=(1,)):
            row = rows.row(r)
            row.write(t, write.minus(row.line(t), write.times(share, write.everywhere(parts.entry(r)))))


@written(_reflect_below)
def reflect_below(rows, top, first, end, head, parts, scale, begin, wide):
    """Multiply row `top` and rows[first:end] by I - scale u u' from the left, u = (head, parts[first:end]).

    From the line on in which entry `begin` is, up to `wide`.
    """
    for t in range(begin & -PAD, wide):
        along = scale * (head * rows[top][t] + sum(parts[r] * rows[r][t] for r in range(first, end)))
        rows[top][t] -= along * head
        for r in range(first, end):
            rows[r][t] -= along * parts[r]
