"""Rows of text as a table: for the terminal, and as CSV."""

from __future__ import annotations

import csv
from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import Annotated

import typer
from rich.box import SIMPLE_HEAD
from rich.console import Console
from rich.table import Table

from hqp.commands.options import file
from hqp.files.names import TABLE, check_name

#: The option that names the file of a table.
Out = Annotated[
    Path | None, typer.Option("--out", "-o", help="Also write the rows to this CSV file.", parser=file(*TABLE))
]
#: One row: what stands under each column.
Row = dict[str, str]
#: The columns that hold words, and those that are in the title of what is printed.
WORDS, TITLE = ("family", "start", "method", "setting", "name", "about", "faster"), ("family", "scene")


def terminal(title: str, rows: Sequence[Row], *, group: str = "") -> Table:
    """A table of these rows, with an empty line where `group` changes."""
    table = Table(title=title, title_justify="left", box=SIMPLE_HEAD, pad_edge=False)
    columns = [column for column in rows[0] if column not in TITLE]
    for column in columns:
        table.add_column(column, justify="left" if column in WORDS else "right", no_wrap=column != "about")
    for row, following in zip(rows, [*rows[1:], {}], strict=True):
        last = bool(group) and row[group] != following.get(group)
        table.add_row(*(row[column] for column in columns), end_section=last)
    return table


def show(printer: Console, table: Table) -> None:
    """Print a table completely: lines wider than the terminal are wrapped, and no number is cut."""
    given = printer.width
    if all(column.no_wrap for column in table.columns):
        printer.width = max(given, printer.measure(table, options=printer.options.update(width=1000)).maximum)
    printer.print(table)
    printer.width = given


def markdown(rows: Sequence[Row]) -> str:
    """A table of these rows for a page."""
    columns = list(rows[0])
    rule = [":--" if column in WORDS else "--:" for column in columns]
    lines = [columns, rule, *([row[column] for column in columns] for row in rows)]
    return "\n".join(f"| {' | '.join(line)} |" for line in lines) + "\n"


def save(path: Path, rows: Iterable[Row]) -> None:
    """Write all rows into one file, called .csv; missing values are left empty."""
    check_name(path, *TABLE)
    rows = list(rows)
    columns = dict.fromkeys(column for row in rows for column in row)
    with path.open("w", newline="") as file:
        writer = csv.DictWriter(file, list(columns), restval="")
        writer.writeheader()
        writer.writerows(rows)
