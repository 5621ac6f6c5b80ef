"""The paper's problem of section IV on a reduced body (FLAPBODY-14), by CasADi with its own equations and IPOPT.

    pip install casadi && python validation/paper_nlp/solve.py > validation/paper_nlp/optima.csv

min t_f + int (z - z_ref)' C (z - z_ref) + 0.05 |u|^2 dt + 0.01 sum |u_k+1 - u_k|^2, z = [roll, pitch, w], C with five entries;
r_i: the state at the start, roll, pitch and rates at the end; g_i: commands, strokes and their differences; t_f free.
Hermite-Simpson with inputs linear between the nodes, the integral by the trapezoid rule over the nodes.
"""

import casadi as ca
import numpy as np

MASS, INERTIA, GRAVITY, DENSITY, AREA = 0.040, ca.DM([1.2e-4, 8.0e-5, 1.6e-4]), 9.81, 1.225, 0.04
SPAN, CHORD, LAG, RATE, DIFFERENCE = 0.30, 0.12, 0.020, 2 * np.pi * 3.5, 1.2
BANK = np.radians(15.0)
FULL = dict(roll=4.0, pitch=1.0, rate=(0.01, 0.02, 0.03))
NONE = dict(roll=0.0, pitch=0.0, rate=(0.0, 0.0, 0.0))


def rates(t, x, u):
    """x = [roll, pitch, yaw, w(3), v(3), s(4), z] with z down, Euler angles Z-Y-X."""
    w, v, s, z = x[3:6], x[6:9], x[9:13], x[13]
    plunge = ca.cos(RATE * t)
    speed = ca.sqrt(ca.sumsqr(v) + 0.01)
    alpha, slip = ca.atan2(v[2], v[0] + 0.3), v[1] / speed
    t1, t2 = ca.tanh(s[0]), ca.tanh(s[1])
    effective = alpha + 0.8 * plunge * (1 + 0.25 * (t1 + t2))
    q = 0.5 * DENSITY * AREA * speed**2
    lift = 4.5 * ca.sin(effective) * ca.cos(effective) - 0.5 * z
    drag = 0.15 + 0.9 * ca.sin(effective) ** 2
    thrust = 0.25 * (1 + 0.3 * plunge + 0.2 * (s[0] + s[1]))
    force = ca.vertcat(
        q * (lift * ca.sin(alpha) - drag * ca.cos(alpha)) + thrust,
        -0.8 * q * slip,
        -q * (lift * ca.cos(alpha) + drag * ca.sin(alpha)),
    )
    roll = 0.08 * (t1 - t2) * (1 + 0.5 * plunge) - 0.15 * w[0] * SPAN / speed
    pitch = 0.25 * (ca.tanh(s[2]) + 0.5 * plunge * s[3]) - 0.30 * alpha - 1.5 * w[1] * CHORD / speed + 0.05 * plunge
    yaw = 0.06 * (s[3] - 0.5 * plunge * s[2]) + 0.05 * slip - 0.10 * w[2] * SPAN / speed
    moment = q * ca.vertcat(roll * SPAN, pitch * CHORD, yaw * SPAN)
    sp, cp, st, ct = ca.sin(x[0]), ca.cos(x[0]), ca.sin(x[1]), ca.cos(x[1])
    turn = sp * w[1] + cp * w[2]
    weight = GRAVITY * ca.vertcat(-st, sp * ct, cp * ct)
    return ca.vertcat(
        w[0] + st / ct * turn,
        cp * w[1] - sp * w[2],
        turn / ct,
        (moment - ca.cross(w, INERTIA * w)) / INERTIA,
        force / MASS - ca.cross(w, v) + weight,
        (u - s) / LAG,
        speed * 2 / CHORD * (0.165 * (effective - z) - 0.0455 * z),
    )


def solve(n, cost):
    opti = ca.Opti()
    x, u, tf = opti.variable(14, n + 1), opti.variable(4, n + 1), opti.variable()
    start = np.zeros(14)
    start[1], start[6], start[8] = -BANK, 1.0, 0.1
    h = tf / n
    f = [rates(k * h, x[:, k], u[:, k]) for k in range(n + 1)]
    for k in range(n):
        middle = (x[:, k] + x[:, k + 1]) / 2 + h / 8 * (f[k] - f[k + 1])
        between = rates((k + 0.5) * h, middle, (u[:, k] + u[:, k + 1]) / 2)
        opti.subject_to(x[:, k + 1] - x[:, k] == h / 6 * (f[k] + 4 * between + f[k + 1]))

    def running(k):
        r, p, w = x[0, k] - BANK, x[1, k] + BANK, x[3:6, k]
        attitude = cost["roll"] * r**2 + cost["pitch"] * p**2
        return attitude + sum(c * w[i] ** 2 for i, c in enumerate(cost["rate"])) + 0.05 * ca.sumsqr(u[:, k])

    integral = sum(h / 2 * (running(k) + running(k + 1)) for k in range(n))
    change = sum(ca.sumsqr(u[:, k + 1] - u[:, k]) for k in range(n))
    opti.minimize(tf + integral + 0.01 * change)
    opti.subject_to(opti.bounded(0.10, tf, 0.60))
    opti.subject_to(x[:, 0] == start)
    opti.subject_to(x[0:2, n] == ca.DM([BANK, -BANK]))
    opti.subject_to(x[3:6, n] == 0)
    for k in range(n + 1):
        opti.subject_to(opti.bounded(-1, u[:, k], 1))
        opti.subject_to(opti.bounded(-DIFFERENCE, x[9, k] - x[10, k], DIFFERENCE))
        opti.subject_to(opti.bounded(-DIFFERENCE, x[11, k] - x[12, k], DIFFERENCE))
        if k > 0:
            opti.subject_to(opti.bounded(-1, x[9:13, k], 1))
            opti.subject_to(opti.bounded(-np.radians(60), x[0:2, k], np.radians(60)))
            opti.subject_to(opti.bounded(-15, x[3:6, k], 15))
    guess = np.tile(start[:, None], (1, n + 1))
    guess[0] = np.linspace(0, BANK, n + 1)
    opti.set_initial(x, guess)
    opti.set_initial(tf, 0.3)
    opti.solver("ipopt", {"print_time": False}, {"print_level": 0, "sb": "yes", "tol": 1e-10})
    solution = opti.solve()
    return solution.value(opti.f), solution.value(tf), solution.stats()["iter_count"]


if __name__ == "__main__":
    print(f"# the paper's problem on FLAPBODY-14: CasADi {ca.__version__} with IPOPT, tol 1e-10; validation/paper_nlp/solve.py")
    print("intervals,roll,pitch,rate_x,rate_y,rate_z,objective,t_f,iterations")
    for n, cost in [(50, NONE), (50, FULL), (100, FULL)]:
        objective, tf, iterations = solve(n, cost)
        entries = [cost["roll"], cost["pitch"], *cost["rate"]]
        print(",".join(str(v) for v in [n, *entries]) + f",{objective:.14e},{tf:.14e},{iterations}")
