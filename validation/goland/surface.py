"""Flutter of Goland's wing on a beam of cubic elements in the air of a lattice in the frequency domain, apart from the program.

    pip install numpy scipy && python validation/goland/surface.py > validation/goland/surface.csv

Rings of vortices lie on the flat wing and its mirror image, tangent flow at three quarters of a panel. The jump of the potential
in the wake lags by its age, whose rings are as long as those of the wing. Pressure over the density: U d/dx + d/dt of the jump.
"""

import numpy as np
from scipy.linalg import eigh

SPAN, CHORD, AXIS, CENTRE = 6.096, 1.8288, 0.33, 0.43
BENDING, TORSION, MASS, INERTIA, DENSITY = 9.77e6, 0.987e6, 35.71, 8.64, 1.02
MODES, ELEMENTS, WAKE = 4, 40, 30.0  # wake in chords


def shapes(s, l):
    """Hermite's cubics and three quadratics on an element of length l, s from 0 to 1."""
    cubic = [1 - 3 * s**2 + 2 * s**3, l * (s - 2 * s**2 + s**3), 3 * s**2 - 2 * s**3, l * (s**3 - s**2)]
    return np.array(cubic), np.array([(1 - s) * (1 - 2 * s), 4 * s * (1 - s), s * (2 * s - 1)])


def modes(y):
    """Frequencies squared, displacement down and twist nose up at y of the lowest modes of unit mass."""
    l, bends, twists = SPAN / ELEMENTS, 2 * (ELEMENTS + 1), 2 * ELEMENTS + 1
    stiffness, inertia = np.zeros((2, bends + twists, bends + twists))
    s, w = np.polynomial.legendre.leggauss(5)
    s, w = 0.5 * (s + 1), 0.5 * w * l
    h, t = shapes(s, l)
    bent = np.array([-6 + 12 * s, l * (-4 + 6 * s), 6 - 12 * s, l * (6 * s - 2)]) / l**2
    turned = np.array([4 * s - 3, 4 - 8 * s, 4 * s - 1]) / l
    offset = MASS * (CENTRE - AXIS) * CHORD
    for e in range(ELEMENTS):
        at = np.r_[2 * e : 2 * e + 4, bends + 2 * e : bends + 2 * e + 3]
        k, m = np.zeros((7, 7)), np.zeros((7, 7))
        k[:4, :4], k[4:, 4:] = BENDING * (bent * w) @ bent.T, TORSION * (turned * w) @ turned.T
        m[:4, :4], m[4:, 4:] = MASS * (h * w) @ h.T, INERTIA * (t * w) @ t.T
        m[:4, 4:] = offset * (h * w) @ t.T
        m[4:, :4] = m[:4, 4:].T
        stiffness[np.ix_(at, at)] += k
        inertia[np.ix_(at, at)] += m
    free = [i for i in range(bends + twists) if i not in (0, 1, bends)]
    squares, vectors = eigh(stiffness[np.ix_(free, free)], inertia[np.ix_(free, free)])
    full = np.zeros((bends + twists, MODES))
    full[free] = vectors[:, :MODES]
    e = np.minimum((y / l).astype(int), ELEMENTS - 1)
    h, t = shapes(y / l - e, l)
    down = sum(h[k][:, None] * full[2 * e + k] for k in range(4))
    return squares[:MODES], down, sum(t[k][:, None] * full[bends + 2 * e + k] for k in range(3))


def wash(x, y, x1, x2, y1, y2):
    """Wash up of rings of unit strength: 1/(4 pi) of the finite part of the integral of 1/r^3, whose corners are -R/(X Y)."""

    def corner(a, b):
        return np.hypot(x - a, y - b) / ((x - a) * (y - b))

    return -(corner(x2, y2) - corner(x1, y2) - corner(x2, y1) + corner(x1, y1)) / (4 * np.pi)


class Surface:
    """Panels along chord and half span; the lattice ends `inset` of a panel inboard of the tip (Hough 1973: a quarter)."""

    def __init__(self, chordwise, half, inset):
        self.dx, self.dy = CHORD / chordwise, SPAN / (half + inset)
        self.front = (np.arange(chordwise) + 0.25) * self.dx
        ends = np.arange(half + 1) * self.dy
        self.x, middle = self.front + 0.5 * self.dx, ends[:-1] + 0.5 * self.dy
        x, y = (a.ravel()[:, None] for a in np.meshgrid(self.x, middle, indexing="ij"))

        def both(first):
            sides = [(ends[:-1], ends[1:]), (-ends[1:], -ends[:-1])]
            return sum(wash(x, y, first, first + self.dx, *side) for side in sides)

        self.wing = np.concatenate([both(first) for first in self.front], axis=1)
        steps = int(WAKE * chordwise)
        self.wake = np.stack([both(self.front[-1] + k * self.dx) for k in range(1, steps + 1)])
        self.squares, self.down, self.twist = modes(middle)

    def work(self, k):
        """Work of the loads of a mode on another over the density, in a wind of 1 m/s, at the reduced frequency k."""
        omega = 2 * k / CHORD
        lag = np.exp(-1j * omega * self.dx * np.arange(1, len(self.wake) + 1))
        system = self.wing.astype(complex)
        strips = len(self.down)
        system[:, -strips:] += np.tensordot(lag, self.wake, axes=1)
        arm = (self.x - AXIS * CHORD)[:, None, None]
        normal = 1j * omega * (-self.down - self.twist * arm) - self.twist
        jump = np.linalg.solve(system, normal.reshape(len(system), -1)).reshape(normal.shape)
        steady = np.diff(jump, axis=0, prepend=0)
        # The last quarter of the last ring lies in the wake.
        long = np.full(len(self.x), self.dx)
        long[-1] *= 0.75
        moving = 1j * omega * jump * long[:, None, None]
        at = [self.front - AXIS * CHORD, self.front + 0.5 * long - AXIS * CHORD]
        lift = (steady + moving).sum(0) * self.dy
        nose = -sum((p * a[:, None, None]).sum(0) for p, a in zip((steady, moving), at)) * self.dy
        return self.twist.T @ nose - self.down.T @ lift

    def flutter(self):
        """Speed and frequency where the damping that a harmonic motion needs turns positive."""

        def roots(k):
            loads = DENSITY * (0.5 * CHORD / k) ** 2 * self.work(k)
            return np.linalg.eigvals((np.eye(MODES) + loads) / self.squares[:, None])

        found, k, factor = [], 0.55, 0.97
        before = roots(k)
        while k > 0.27:
            after = roots(k * factor)
            for x in after:
                old = before[np.argmin(abs(before - x))]
                if old.imag < 0 <= x.imag and x.real > 0:
                    share = old.imag / (old.imag - x.imag)
                    omega = (old + share * (x - old)).real ** -0.5
                    found.append((omega * 0.5 * CHORD / (k * (1 + share * (factor - 1))), omega))
            k, before = k * factor, after
        return min(found)


print("# Flutter of Goland's wing in air of 1.02 kg/m3 by a lattice in the frequency domain: validation/goland/surface.py")
print("# Two series of grids of one shape each; the error falls as the size of a panel.")
print("inset,chordwise,half,speed_m_s,frequency_rad_s")
for inset in (0.0, 0.25):
    for chordwise in (6, 12, 18):
        half = chordwise * 5 // 3
        speed, frequency = Surface(chordwise, half, inset).flutter()
        print(f"{inset},{chordwise},{half},{speed:.3f},{frequency:.3f}", flush=True)
