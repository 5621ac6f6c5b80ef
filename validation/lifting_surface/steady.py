"""Lift slopes of flat rectangles by a planar lattice of horseshoes: the lattice columns of steady.csv, and what they tend to.

    pip install numpy && python validation/lifting_surface/steady.py

Vortices and control points lie by Lan's rule along chord and span (C. E. Lan, J. Aircraft 11 (1974) 518-527). The last line holds the
slope of a square wing with 6, 12 and 24 panels along the chord, and its limit by Richardson's extrapolation, the order fitted.
"""

import numpy as np


def slope(aspect, nc, ns):
    """CL over the incidence, 1/rad, of nc panels along the chord and ns along the span, both halves alike."""
    k, j = np.arange(1, nc + 1), np.arange(1, ns + 1)
    vortex, point = 0.5 - 0.5 * np.cos((k - 0.5) * np.pi / nc), 0.5 - 0.5 * np.cos(k * np.pi / nc)
    edge = -0.5 * aspect * np.cos((np.arange(ns + 1) + 0.5) * np.pi / (ns + 1))
    middle = -0.5 * aspect * np.cos(j * np.pi / (ns + 1))
    half = ns // 2
    assert ns == 2 * half, "an even number of panels along the span"
    system = np.zeros((nc, half, nc, half))
    across = middle[:half, None] - edge
    for row in range(nc):
        for column in range(nc):
            along = point[row] - vortex[column]
            leg = (1.0 + np.hypot(along, across) / along) / across
            wash = (leg[:, :-1] - leg[:, 1:]) / (4.0 * np.pi)
            system[row, :, column] = wash[:, :half] + wash[:, : half - 1 : -1]
    strength = np.linalg.solve(system.reshape(nc * half, -1), np.ones(nc * half)).reshape(nc, half)
    return abs(4.0 * (strength * np.diff(edge)[:half]).sum() / aspect)


if __name__ == "__main__":
    print("AR,CLalpha_8x40,CLalpha_10x80,CLalpha_12x120")
    for aspect in (1, 2, 3, 4, 6, 8, 10, 20):
        print(aspect, *(f"{slope(aspect, *panels):.6f}" for panels in ((8, 40), (10, 80), (12, 120))), sep=",")
    coarse, middle, fine = (slope(1, nc, 160) for nc in (6, 12, 24))
    gain = (middle - coarse) / (fine - middle)
    print(f"# square: {coarse:.6f}, {middle:.6f}, {fine:.6f}; limit {fine + (fine - middle) / (gain - 1.0):.6f}")
