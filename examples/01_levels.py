"""Two wishes that contradict each other: four ways to rank them, and what the residuals say."""

from hqp import Hierarchy, Level, certify, solve

limits = Level.bounds([-1, -1], [1, 1], name="limits")  # -1 <= x <= 1
# Within the limits the sum is 2 at the most, and then the difference is 0: the two wishes contradict each other.
total = Level.equality([[1, 1]], [3], name="sum")
difference = Level.equality([[1, -1]], [1], name="difference")
both = Level.equality([[1, 1], [1, -1]], [3, 1], name="both")
weighted = Level.equality([[1, 1], [1, -1]], [3, 1], weights=[1, 3], name="both, weighted")

orders = {
    "limits > sum > difference": [limits, total, difference],
    "limits > difference > sum": [limits, difference, total],
    "limits > both, the difference with weight 3": [limits, weighted],
    "both > limits": [both, limits],
}
answers = {}
for order, levels in orders.items():
    solution = solve(Hierarchy(levels))
    answers[order] = solution.x
    x, y = solution.x.round(4) + 0.0
    print(f"{order}\n    x = ({x:g}, {y:g}), sum {x + y:g}, difference {x - y:g}")
    print("    residuals:", ", ".join(f"{level.name} {level.residual_norm:.4f}" for level in solution.levels))
    print("    proved:", solution.certify().ok)

print("\nThe certificate knows no backend. Put to the first order, the third answer falls short:")
print(certify(Hierarchy(orders["limits > sum > difference"]), answers["limits > both, the difference with weight 3"]))
