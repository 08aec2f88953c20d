"""The plans that have a name."""

from __future__ import annotations

from .plan import Plan

PLANS: dict[str, Plan] = {
    plan.name: plan
    for plan in (
        Plan(
            "full",
            "all families, all methods that are here, both settings",
            settings=("tight", "loose"),
            draws=128,
            few=16,
        ),
        Plan(
            "smoke",
            "a bit of everything, in less than a minute",
            families=(
                "thesis/*",
                "motion/p*",
                "random/*50%",
                "adversarial/*",
                "control/P[123]",
                "contacts/go2 balanced",
                "equalities/n 7*",
                "size/* ?",
            ),
            methods=("native", "pseudoinverse", "daqp*", "cascade:proxsuite", "cascade:osqp"),
            draws=4,
            few=2,
            block=4,
            rounds=2,
        ),
        Plan("growth", "time over unknowns, levels and rows", families=("size/*",)),
        Plan(
            "motion",
            "what controllers solve: recorded motions, with contacts too, and the thesis",
            families=("motion/*", "contacts/*", "thesis/*"),
        ),
        Plan("adversarial", "what breaks solvers", families=("adversarial/*",), draws=256, few=32, rounds=1),
        Plan(
            "tails",
            "the slowest of a thousand problems of each family, by what can be called at 1 kHz",
            families=("motion/*", "contacts/*", "thesis/*", "random/*", "control/*"),
            methods=("native", "daqp*"),
            draws=1024,
            block=64,
        ),
    )
}
