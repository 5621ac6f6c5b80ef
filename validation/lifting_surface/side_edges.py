"""Suction of the side edges of flat and parabolically cambered rectangles in steady flow by a planar vortex lattice.

    pip install numpy && python validation/lifting_surface/side_edges.py > validation/lifting_surface/side_edges.csv

With the incidence a and the camber h (height over the chord), both small, the pull of both edges over q S is
flat a^2 + 2 mixed a h + camber h^2; that times the distance behind mid chord over the chord is flat_behind a^2 + ...
Panels lie by Lan's rule along the chord and evenly along the span, a quarter of a panel inside the tips; the pull is that on the
legs of the outer half of each wing by the Kutta-Joukowski theorem.
"""

import sys

import numpy as np

CHORDWISE, SPANWISE = (int(n) for n in sys.argv[1:3]) if len(sys.argv) > 2 else (24, 120)
DIRECTIONS = np.array([[1.0, 0.0], [0.0, 1.0], [1.0, 1.0]])


def downwash(points, bound, left, right):
    """Upward velocity at points (x, y) of horseshoes of unit circulation, their legs towards +x."""
    x, a, b = points[:, None, 0] - bound, points[:, None, 1] - left, points[:, None, 1] - right
    with np.errstate(all="ignore"):
        front = np.where(np.abs(x) < 1e-12, 0.0, (a / np.hypot(x, a) - b / np.hypot(x, b)) / x)
        leg = lambda d: np.where(np.abs(d) < 1e-12, 0.0, (1.0 + x / np.hypot(x, d)) / d)
        return -(front + leg(a) - leg(b)) / (4.0 * np.pi)


def pull(aspect, nc, ns):
    """Rows flat, mixed, camber of the pull and of its moment."""
    width = aspect / (ns + 0.5)
    edges = -aspect / 2 + 0.25 * width + width * np.arange(ns + 1)
    i = np.arange(1, nc + 1)
    bound = 0.5 * (1 - np.cos((2 * i - 1) * np.pi / (2 * nc)))
    control = 0.5 * (1 - np.cos(i * np.pi / nc))
    at, left = (grid.ravel() for grid in np.meshgrid(bound, edges[:-1], indexing="ij"))
    right = np.tile(edges[1:], nc)
    x, y = (grid.ravel() for grid in np.meshgrid(control, 0.5 * (edges[1:] + edges[:-1]), indexing="ij"))
    matrix = downwash(np.stack([x, y], -1), at, left, right)
    normal = lambda x: np.stack([np.ones_like(x), -4 * (1 - 2 * x)], -1)
    solved = np.linalg.solve(matrix, -normal(x))
    stations = np.append(bound, 1.0)
    sums = []
    for direction, strength in zip(DIRECTIONS, DIRECTIONS @ solved.T):
        ahead = np.cumsum(strength.reshape(nc, ns), axis=0)
        legs = np.zeros((nc, ns + 1))
        legs[:, :-1] += ahead
        legs[:, 1:] -= ahead
        parts = []
        for row in range(nc):
            middle, length = 0.5 * (stations[row] + stations[row + 1]), stations[row + 1] - stations[row]
            points = np.stack([np.full(ns + 1, middle), edges], -1)
            wash = normal(points[:, 0]) @ direction + downwash(points, at, left, right) @ strength
            # Of both halves, over S/2 of the chord 1.
            force = 2 * (legs[row] * wash)[ns // 2 + 1 :].sum() * length * 2 / aspect
            parts.append([force, force * (middle - 0.5)])
        sums.append(np.abs(np.sum(parts, axis=0)))
    flat, camber, both = sums
    return np.stack([flat, 0.5 * (both - flat - camber), camber])


print("# Pull of the side edges of rectangles over q S: see side_edges.py. numpy " + np.__version__)
print(f"# {CHORDWISE} x {SPANWISE} panels; with 20 x 80 they differ by at most 3 %, flat by 0.4 %.")
print("aspect,flat,mixed,camber,flat_behind,mixed_behind,camber_behind")
for aspect in (1, 2, 4, 8):
    found = pull(aspect, CHORDWISE, SPANWISE)
    print(aspect, *(f"{value:.4f}" for value in found.T.ravel()), sep=",")
