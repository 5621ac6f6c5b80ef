"""Running time of CasADi + IPOPT on FLAPBODY-14 B, N = 100, from its stated guess.

Prints name<TAB>seconds of the processor: one solve, and what of it is left without the
evaluation of the problem's functions, the least of three each.
"""
import casadi as ca
import numpy as np

from flapbody14 import DEG, NU, NX, rates


def problem(N):
    """Stage by stage w = [x_0, u_0, x_1, .., t_f]."""
    t, x, u = ca.SX.sym("t"), ca.SX.sym("x", NX), ca.SX.sym("u", NU)
    f = ca.Function("f", [t, x, u], [rates(t, x, u)])
    start = np.array([0, -15 * DEG, 0, 0, 0, 0, 1.0, 0, 0.1, 0, 0, 0, 0, 0])
    xs = [ca.SX.sym(f"x{k}", NX) for k in range(N + 1)]
    us = [ca.SX.sym(f"u{k}", NU) for k in range(N + 1)]
    tf = ca.SX.sym("tf")
    h = tf / N
    fs = [f(k * h, xs[k], us[k]) for k in range(N + 1)]
    w, low, high, guess, g, glow, ghigh, J = [], [], [], [], [], [], [], tf
    for k in range(N + 1):
        box = np.full(NX, np.inf)
        box[0:2], box[3:6], box[9:13] = 60 * DEG, 15, 1.0
        lo, hi = -box, box.copy()
        if k == 0:
            lo, hi = start.copy(), start.copy()
        if k == N:
            lo[[0, 1, 3, 4, 5]] = hi[[0, 1, 3, 4, 5]] = [15 * DEG, -15 * DEG, 0, 0, 0]
        first = start.copy()
        first[0] = 15 * DEG * k / N
        w += [xs[k], us[k]]
        low, high, guess = low + [*lo, *[-1] * NU], high + [*hi, *[1] * NU], guess + [*first, *[0] * NU]
        J += 0.05 * h * (0.5 if k in (0, N) else 1.0) * ca.sumsqr(us[k])
        if k < N:
            J += 0.01 * ca.sumsqr(us[k + 1] - us[k])
            xc = (xs[k] + xs[k + 1]) / 2 + h / 8 * (fs[k] - fs[k + 1])
            fc = f((k + 0.5) * h, xc, (us[k] + us[k + 1]) / 2)
            g.append(xs[k + 1] - xs[k] - h / 6 * (fs[k] + 4 * fc + fs[k + 1]))
            glow, ghigh = glow + [0] * NX, ghigh + [0] * NX
        g.append(ca.vertcat(xs[k][9] - xs[k][10], xs[k][11] - xs[k][12]))
        glow, ghigh = glow + [-1.2] * 2, ghigh + [1.2] * 2
    nlp = dict(x=ca.vertcat(*w, tf), f=J, g=ca.vertcat(*g))
    return nlp, dict(x0=guess + [0.3], lbx=low + [0.1], ubx=high + [0.6], lbg=glow, ubg=ghigh)


nlp, arguments = problem(100)
quiet = dict(print_time=False, record_time=True, ipopt=dict(print_level=0, sb="yes"))
solver = ca.nlpsol("solver", "ipopt", nlp, quiet)
seconds, without = [], []
for _ in range(3):
    solver(**arguments)
    stats = solver.stats()
    seconds.append(stats["t_proc_total"])
    without.append(seconds[-1] - sum(t for name, t in stats.items() if name.startswith("t_proc_nlp_")))
print(f"flapbody14_b\t{min(seconds)}")
print(f"flapbody14_b_without_evaluation\t{min(without)}")
