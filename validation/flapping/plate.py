"""Small heave of a teardrop with an elastic plate behind it in plane, inviscid flow: four modes of a cantilever and vortices.

    pip install numpy && python validation/flapping/plate.py > validation/flapping/plate.csv

Vortices stand at the quarter of each piece of the chord, the flow is tangent at its three quarters, and what the circulation changes by
drifts with the stream. Pressure rho (U gamma + d/dt of the circulation ahead); the suction of the leading edge from the first vortex.
"""

import numpy as np

DENSITY, SPEED, CHORD, HEAVE, CLAMP = 1000.0, 0.1, 0.09, 0.0175, 0.03
MODULUS, POISSON, PLATE = 2.05e11, 0.3, 7800.0
PIECES, WAKE = 90, 60  # wake in chords
LENGTH = CHORD - CLAMP
# Roots of cos cosh = -1, and the ratios of the mode shapes (Blevins 1979).
ROOTS = np.array([1.87510407, 4.69409113, 7.85475744, 10.99554073])
RATIOS = np.array([0.734095514, 1.018467319, 0.999224497, 1.000033553])

dx = CHORD / PIECES
front = (np.arange(PIECES) + 0.25) * dx
control = front + 0.5 * dx
middle = front + 0.5 * dx
middle[-1] -= 0.125 * dx  # the last quarter of the last piece lies in the wake
length = np.full(PIECES, dx)
length[-1] *= 0.75


def wash(x, at):
    """Wash up at x of a lifting vortex of unit strength."""
    return -1 / (2 * np.pi * (x[:, None] - at[None, :]))


def shapes(x):
    """Heave, then the cantilever's modes with a tip of +-1: heights and slopes."""
    z = np.clip((x - CLAMP) / LENGTH, 0, None)
    at = ROOTS[:, None] * z
    high = np.cosh(at) - np.cos(at) - RATIOS[:, None] * (np.sinh(at) - np.sin(at))
    steep = np.sinh(at) + np.sin(at) - RATIOS[:, None] * (np.cosh(at) - np.cos(at))
    steep = steep * ROOTS[:, None] / LENGTH
    heave = np.ones((1, len(x)))
    return np.vstack([heave, 0.5 * high]), np.vstack([0 * heave, 0.5 * steep])


bound = wash(control, front)
# A flat plate of unit wash has the suction sqrt(chord).
edge = np.sqrt(CHORD) / np.linalg.solve(bound, -np.ones(PIECES))[0]
drifted = wash(control, CHORD + (np.arange(WAKE * PIECES) + 0.5) * dx)


def solve(thickness, strouhal):
    """Thrust over 0.5 rho U^2 c and amplitude of the line from edge to edge, deg."""
    omega = np.pi * strouhal * SPEED / HEAVE
    age = (np.arange(WAKE * PIECES) + 0.5) * dx
    shed = drifted @ (-1j * omega / SPEED * dx * np.exp(-1j * omega / SPEED * age))
    high, steep = shapes(control)
    gamma = np.linalg.solve(bound + shed[:, None], (1j * omega * high + SPEED * steep).T)
    steady = DENSITY * SPEED * gamma
    moving = 1j * DENSITY * omega * np.cumsum(gamma, 0) * length[:, None]
    (on, tilt), (over, tilts) = shapes(front), shapes(middle)
    work = on @ steady + over @ moving
    b = thickness * CHORD
    stiffness = MODULUS * b**3 / (12 * (1 - POISSON**2)) * ROOTS**4 / LENGTH**3 / 4
    mass = PLATE * b * LENGTH / 4
    s = np.linspace(CLAMP, CHORD, 2001)
    carried = PLATE * b * np.trapezoid(shapes(s)[0][1:], s, axis=1)
    system = np.diag(stiffness - omega**2 * mass) - work[1:, 1:]
    moved = np.r_[HEAVE, np.linalg.solve(system, (work[1:, 0] + omega**2 * carried) * HEAVE)]
    suction = 0.5 * np.pi * DENSITY * abs(edge * gamma[0] @ moved) ** 2
    loads = [(steady, tilt), (moving, tilts)]
    # Forward: the load times the slope, which rises aft.
    normal = sum(0.5 * np.real(np.sum((load @ moved) * np.conj(slope.T @ moved))) for load, slope in loads)
    tip = abs(shapes(np.array([CHORD]))[0][1:, 0] @ moved[1:])
    return (suction + normal) / (0.5 * DENSITY * SPEED**2 * CHORD), np.degrees(tip / CHORD)


print("# Thrust over 0.5 rho U^2 c and amplitude of the line from edge to edge (deg) in linear theory: validation/flapping/plate.py")
print("thickness,strouhal,thrust,pitch_deg")
for strouhal in (0.273, 0.345):
    for thickness in (0.56e-3, 0.85e-3, 1.13e-3, 1.41e-3, 1.69e-3, 2.23e-3, 4.23e-3):
        thrust, pitch = solve(thickness, strouhal)
        print(f"{thickness:.2e},{strouhal},{thrust:.4f},{pitch:.3f}")
