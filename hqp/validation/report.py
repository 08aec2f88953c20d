"""The report as files: text, picture, and every number."""

from __future__ import annotations

import csv
import io
import platform
from collections.abc import Iterator
from dataclasses import fields
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from ..arrays import Array
from ..backends import backend_info
from ..settings import Settings
from . import tables, zone
from .picture import draw
from .results import Results

if TYPE_CHECKING:
    from matplotlib.figure import Figure

TEXT, PICTURE, NUMBERS = FILES = "validation.md", "validation.png", "validation.csv"
DPI = 90

#: Of a row of the CSV; what does not apply is empty.
COLUMNS = (
    "check", "formula", "backend", "case", "targets", "sigma", "zone", "stacks",
    "x_least", "x_median", "x_most", "residual_least", "residual_median", "residual_most",
    "length_median", "multipliers", "certified", "failures", "refuted", "beaten", "beaten_by", "allowed", "ok",
)  # fmt: skip


def write(results: Results, out: Path) -> None:
    """Write the three files; each appears whole or not at all."""
    _whole(out / TEXT, to_markdown(results).encode())
    _whole(out / PICTURE, _png(draw(results.points, results.partings)))
    _whole(out / NUMBERS, to_csv(results).encode())


def _png(figure: Figure) -> bytes:
    """In 256 colours, a third of the size."""
    from PIL import Image

    drawn, small = io.BytesIO(), io.BytesIO()
    figure.savefig(drawn, dpi=DPI)
    Image.open(drawn).convert("RGB").quantize(256, dither=Image.Dither.NONE).save(small, "png", optimize=True)
    return small.getvalue()


def _whole(path: Path, data: bytes) -> None:
    part = path.with_stem(f".{path.stem}-part")
    part.write_bytes(data)
    part.replace(path)


def to_csv(results: Results) -> str:
    """One row a comparison: a case, a singular value, a relation or a known answer."""
    out = io.StringIO()
    writer = csv.DictWriter(out, COLUMNS, lineterminator="\n")
    writer.writeheader()
    writer.writerows(_rows(results))
    return out.getvalue()


def _rows(results: Results) -> Iterator[dict[str, object]]:
    for report in results.reports:
        yield {
            "check": "closed form", "formula": report.formula, "backend": report.backend, "case": report.case,
            "stacks": report.count, "x_most": f"{report.worst_x:.4g}", "residual_most": f"{report.worst_residual:.4g}",
            "certified": report.certified, "failures": report.failures, "allowed": report.allowed, "ok": report.ok,
        }  # fmt: skip
    for point in results.points:
        yield {
            "check": "singular", "formula": point.formula, "backend": point.name, "case": point.place,
            "targets": point.targets, "sigma": f"{point.sigma:.4g}", "zone": zone(point.sigma),
            "stacks": len(point.x), **_spread("x", point.x), **_spread("residual", point.residual),
            "length_median": f"{np.median(point.length):.4g}", "certified": point.certified, "failures": point.failures,
            "allowed": point.allowed, "ok": point.ok,
        }  # fmt: skip
    for parting in results.partings:
        near = not np.isnan(parting.sigma)
        yield {
            "check": "Eq. 4.8 and strict", "case": parting.relation, "targets": "any",
            **({"sigma": f"{parting.sigma:.4g}", "zone": zone(parting.sigma)} if near else {}),
            "stacks": len(parting.x), **_spread("x", parting.x), **_spread("residual", parting.residual),
            "length_median": f"{np.median(parting.joint):.4g}", "certified": parting.certified, "ok": parting.ok,
        }  # fmt: skip
    for each in results.judgements:
        yield {
            "check": "random hierarchy", "backend": each.backend, "case": f"n = {each.n}, {each.levels} levels",
            "stacks": each.count, "certified": each.certified, "failures": each.failures, "refuted": each.refuted,
            "beaten": each.beaten, "beaten_by": " ".join(each.by), "allowed": each.allowed, "ok": each.ok,
        }  # fmt: skip
    for found in results.findings:
        yield {
            "check": "known answer", "backend": found.backend, "case": found.name, "stacks": 1,
            "x_most": f"{found.x:.4g}", "residual_most": f"{found.residual:.4g}",
            "multipliers": "" if np.isnan(found.multipliers) else f"{found.multipliers:.4g}",
            "certified": int(found.certified), "failures": int(not found.claimed), "allowed": found.allowed,
            "ok": found.ok,
        }  # fmt: skip


def _spread(name: str, values: Array) -> dict[str, object]:
    found = values.min(), np.median(values), values.max()
    return {f"{name}_{which}": f"{value:.4g}" for which, value in zip(("least", "median", "most"), found, strict=True)}


def to_markdown(results: Results) -> str:
    """The whole report but the picture."""
    verdict = (
        f"**Outside their class: {', '.join(results.wrong)}.**"
        if results.wrong
        else "Every backend is inside its class wherever the rank is decidable."
    )
    missed = tables.misses(results.findings)
    parts = [
        "# Validation",
        verdict,
        f"{results.count} random stacks a case, {results.near} at every singular value, {results.whole} random"
        f" hierarchies of every size, seed {results.seed}. Every number is in `{NUMBERS}`.",
        "## Closed forms",
        CLOSED_FORMS,
        *(text for table in tables.closed_forms(results.reports, cases=False) for text in _titled(table)),
        "## Singularities",
        f"![Difference from the closed forms over the smallest singular value]({PICTURE})",
        SINGULARITIES,
        *(text for table in tables.near_singular(results.points, places=True) for text in _titled(table)),
        "## Two formulas",
        TWO_FORMULAS,
        tables.two_formulas(results.partings).markdown(),
        "## Random hierarchies",
        RANDOM_HIERARCHIES,
        tables.random_hierarchies(results.judgements, sizes=True).markdown(),
        "## Known answers",
        KNOWN_ANSWERS,
        tables.known(results.findings).markdown(),
        *(["Missed:", missed.markdown()] if missed.rows else ["None is missed."]),
        tables.answers().markdown(),
        "## Made with",
        _versions(results),
    ]
    return "\n\n".join(parts) + "\n"


def _titled(table: tables.Table) -> tuple[str, str]:
    return f"### {table.title}", table.markdown()


def _versions(results: Results) -> str:
    packages = {"hqp", "numpy", "scipy", "numba", "qpsolvers"} | {
        backend_info(name).install for name in results.backends if backend_info(name).install
    }
    found = [f"Python {platform.python_version()}", f"{platform.system()} {platform.machine()}"]
    for name in sorted(packages):
        try:
            found.append(f"{name} {version(name)}")
        except PackageNotFoundError:  # a checkout on the path
            continue
    settings = Settings()
    values = ", ".join(f"`{field.name}` {getattr(settings, field.name)}" for field in fields(settings))
    return f"{', '.join(found)}.\n\nSettings: {values}."


CLOSED_FORMS = """\
Random equality stacks of six shapes in four rank cases, with random weights and a random $z$, the reference of the last
level. *x*: the largest $\\lVert x - x_c\\rVert / \\lVert x_c\\rVert$ from the closed form $x_c$; *residual*: the
largest difference of a level's residual norm, relative to
$\\lVert b_k\\rVert + \\lVert A_k\\rVert \\lVert x_c\\rVert$; *proved*: what the certificate accepts; *solved*, *met*:
levels a stack which the named QP solver solved, and which needed none. Against Eq. 4.8 all but itself solve the
hierarchy whose optimum it is, the first task above $x = J_2^{\\sharp} h_2$."""

SINGULARITIES = """\
Stacks of two levels, 3 rows each, 7 unknowns. All singular values are 1 but those called $\\sigma$: the smallest of
$J_1$ (*inside level 0*) or of $J_2$ (*inside level 1*), a kinematic singularity; or all of
$J_2 (I - J_1^{\\sharp} J_1)$ (*between the levels*, $J_2 = T J_1 + \\sigma E$), an algorithmic one. Lines are medians,
in bands from the least to the largest. In the upper three rows targets are in reach, $b = J x^*$, so that $x$ stays
of its size.

* **From 1 down to the rank tolerance** differences in $x$ follow $\\varepsilon / \\sigma$ (grey): the numbers of the
  stack are rounded, and nobody can do better. The residuals part in the same way, but not because the solvers are
  off. A formula that multiplies by $J^{\\sharp}$ leaves a residual of $\\varepsilon / \\sigma$, least squares by
  orthogonal directions one of $\\varepsilon$: there the certificate refuses the closed form, and accepts the solvers
  (*proved*).
* **Rank undecidable**, from 1e-12 to 1e-6 (shaded). In double precision nobody can tell what is left of a row from the
  round-off in it, and either answer is one. The threshold of the settings is 1e-9 (dashed), of the norm of $J$ for the
  closed forms, of every row for the solvers. Where one keeps the direction and the other does not, $x$ differs by all
  of its part along it, and the residuals by $\\sigma$ times as much: $x$ parts, residuals agree. With targets of any
  size that part is $1 / \\sigma$ long. A formula may be wrong altogether: its projector $I - J^{\\sharp} J$ is off by
  $\\varepsilon / \\sigma$, which for $\\sigma$ < 2e-7 is more than the threshold, so that a direction which is not
  there is taken for one (*pseudoinverse*, third row, left). All this is counted (*outside*), and not judged.
* **Below the tolerance** everybody truncates. Inside a level the closed form cuts the smallest singular vector, and a
  solver what is left of the last row, which is an angle of about $\\sigma$ beside it: differences fall with $\\sigma$
  (blue). Between the levels both cut the same, and agree to round-off.
* **QP regularisation.** A flat QP has $\\rho$ = 1e-7, to be strictly convex, which outweighs a direction with
  $\\sigma^2 < \\rho$ (dotted). What it leaves undone shows in a cascade without polish (*unpolished*) and in `daqp`,
  which has none: again $x$ parts, and residuals hardly. The polish, least squares on the active rows, removes it, so
  that first-order solvers end where exact ones do.
* **Eq. 4.8** needs no $(J_2 N_1)^{\\sharp}$: between the levels it stays at round-off. A singular $J_1$ is no better
  for it, and a singular $J_2$ makes $J_2^{\\sharp} h_2$ itself long, which to all others is a target like any other.

Judged are $\\sigma \\ge$ 1e-6 and $\\sigma \\le$ 1e-12: the larger of the differences in $x$ and in the residuals has
to be within the class. Between them *x*, *residual* and *outside* (of the class, or of 1e-6 where nothing is promised)
are shown as they are."""

TWO_FORMULAS = """\
Eq. 4.8 gives the optimum of the strict stack where $J_1 J_2^T = 0$, where the rows of $J_2$ lie in the row space
of $J_1$, and where the first task is met by $J_2^{\\sharp} h_2$ already. Else it leaves the second task short:
*residual* is by how much more than need be, relative to $\\lVert h_2\\rVert$. The last row of the picture has it on the
way into a singularity, with targets of any size: between the levels the $x$ of the strict stack grows as
$1 / \\sigma$ and that of Eq. 4.8 does not, at the price of its residual. Below the rank tolerance both are the same
again. Strict answers are those of `native`."""

RANDOM_HIERARCHIES = """\
Rows of all kinds at every level, a quarter of them rows from further up again, of different length and with weights,
and a random reference of the last level. *proved*: what the certificate accepts, at the tolerance of the class;
*refuted*: answers that fail at a level which the backend claims; *failed*: claimed not to be optimal; *beaten*: answers
with a level at which another backend attains less, all above being the same."""

KNOWN_ANSWERS = """\
*x*, *residual*, *multipliers*: the largest difference from what is known, over all backends that promise something,
relative to its norm. `daqp` promises nothing; what it misses is listed, not judged. Multipliers are positive at an
upper bound."""
