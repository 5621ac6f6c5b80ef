"""Small heave of a teardrop with an elastic plate behind it in plane, inviscid flow: four modes of a cantilever and thin-aerofoil theory.

    pip install numpy scipy && python validation/flapping/plate.py > validation/flapping/plate.csv

With x = (c/2)(1 - cos t), b = c/2 and k = omega b/U the wash that lifts is the sum of B_n cos n t, and the pressure difference
2 rho U [a_0 cot(t/2) + sum of a_n sin n t] with

    a_0 = C(k) (B_0 - B_1/2) + B_1/2,  a_1 = -B_1 + i k (B_0 - B_2/2),  a_n = -B_n + i k (B_(n-1) - B_(n+1))/(2 n).

C is Theodorsen's function (Theodorsen 1935; Kuessner & Schwarz 1940); the suction of the leading edge is pi rho c a_0^2. With twice as
many terms the numbers written stay the same.
"""

import sys

import numpy as np
from scipy.special import hankel2

DENSITY, SPEED, CHORD, HEAVE, CLAMP = 1000.0, 0.1, 0.09, 0.0175, 0.03
MODULUS, POISSON, PLATE = 2.05e11, 0.3, 7800.0
TERMS = int(sys.argv[1]) if len(sys.argv) > 1 else 200
LENGTH = CHORD - CLAMP
# Roots of cos cosh = -1, and the ratios of the mode shapes (Blevins 1979).
ROOTS = np.array([1.87510407, 4.69409113, 7.85475744, 10.99554073])
RATIOS = np.array([0.734095514, 1.018467319, 0.999224497, 1.000033553])

# The middles of equal parts of t, by which the integrals over t are sums.
angle = (np.arange(8 * TERMS) + 0.5) * np.pi / (8 * TERMS)
part = np.pi / len(angle)
chordwise = 0.5 * CHORD * (1 - np.cos(angle))
order = np.arange(1, TERMS + 1)
waves = np.sin(order[:, None] * angle)


def shapes(x):
    """Heave, then the cantilever's modes with a tip of +-1: heights and slopes."""
    z = np.clip((x - CLAMP) / LENGTH, 0, None)
    at = ROOTS[:, None] * z
    high = np.cosh(at) - np.cos(at) - RATIOS[:, None] * (np.sinh(at) - np.sin(at))
    steep = np.sinh(at) + np.sin(at) - RATIOS[:, None] * (np.cosh(at) - np.cos(at))
    steep = steep * ROOTS[:, None] / LENGTH
    heave = np.ones((1, len(x)))
    return np.vstack([heave, 0.5 * high]), np.vstack([0 * heave, 0.5 * steep])


def pressure(wash, k):
    """Pressure difference times dx/dt, and a_0, of each row of a lifting wash at the angles."""
    b = 2 / np.pi * part * wash @ np.cos(np.arange(TERMS + 2)[:, None] * angle).T
    b[:, 0] /= 2
    theodorsen = hankel2(1, k) / (hankel2(1, k) + 1j * hankel2(0, k))
    edge = theodorsen * (b[:, 0] - b[:, 1] / 2) + b[:, 1] / 2
    before = b[:, :-2].copy()
    before[:, 0] *= 2
    a = -b[:, 1:-1] + 1j * k * (before - b[:, 2:]) / (2 * order)
    load = edge[:, None] * (1 + np.cos(angle)) + a @ waves * np.sin(angle)
    return DENSITY * SPEED * CHORD * load, edge


def solve(thickness, strouhal):
    """Thrust over 0.5 rho U^2 c and amplitude of the line from edge to edge, deg."""
    omega = np.pi * strouhal * SPEED / HEAVE
    high, steep = shapes(chordwise)
    load, edge = pressure(-(1j * omega * high + SPEED * steep), 0.5 * omega * CHORD / SPEED)
    work = part * high @ load.T
    b = thickness * CHORD
    stiffness = MODULUS * b**3 / (12 * (1 - POISSON**2)) * ROOTS**4 / LENGTH**3 / 4
    mass = PLATE * b * LENGTH / 4
    s = np.linspace(CLAMP, CHORD, 2001)
    carried = PLATE * b * np.trapezoid(shapes(s)[0][1:], s, axis=1)
    system = np.diag(stiffness - omega**2 * mass) - work[1:, 1:]
    moved = np.r_[HEAVE, np.linalg.solve(system, (work[1:, 0] + omega**2 * carried) * HEAVE)]
    suction = 0.5 * np.pi * DENSITY * CHORD * abs(edge @ moved) ** 2
    # Forward: the load times the slope, which rises aft.
    normal = 0.5 * part * np.real(np.sum((moved @ load) * np.conj(moved @ steep)))
    tip = abs(shapes(np.array([CHORD]))[0][1:, 0] @ moved[1:])
    return (suction + normal) / (0.5 * DENSITY * SPEED**2 * CHORD), np.degrees(tip / CHORD)


print("# Thrust over 0.5 rho U^2 c and amplitude of the line from edge to edge (deg) in linear theory: validation/flapping/plate.py")
print("thickness,strouhal,thrust,pitch_deg")
for strouhal in (0.273, 0.345):
    for thickness in (0.56e-3, 0.85e-3, 1.13e-3, 1.41e-3, 1.69e-3, 2.23e-3, 4.23e-3):
        thrust, pitch = solve(thickness, strouhal)
        print(f"{thickness:.2e},{strouhal},{thrust:.4f},{pitch:.3f}")
