"""Running times of FLAPBODY-14 A on its 200 recorded instances: CasADi with
IPOPT (generated C code) and with sqpmethod (one iteration) against wingbeat,
instance by instance in turn, one thread each, all from the same cold guess.

Usage: flapbody14.py WORKER INSTANCES.csv BUILD_FOLDER REPEATS
WORKER answers each line "instance iterations" with "microseconds u_0 .. u_23".
Prints one JSON object.
"""
import json
import os
import subprocess
import sys

os.environ.setdefault("OMP_NUM_THREADS", "1")
import casadi as ca
import numpy as np

NX, NU, N, H = 14, 4, 5, 0.005
DEG = np.pi / 180


def rates(t, x, u):
    m, J, g, rho, S, b, c, tau = 0.040, (1.2e-4, 8.0e-5, 1.6e-4), 9.81, 1.225, 0.04, 0.30, 0.12, 0.020
    att, w, v, s, z = x[0:3], x[3:6], x[6:9], x[9:13], x[13]
    V = ca.sqrt(ca.sumsqr(v) + 0.01)
    alpha, slip, pl = ca.atan2(v[2], v[0] + 0.3), v[1] / V, ca.cos(2 * np.pi * 3.5 * t)
    q = 0.5 * rho * V * V * S
    t1, t2 = ca.tanh(s[0]), ca.tanh(s[1])
    a = alpha + 0.8 * pl * (1 + 0.25 * t1 + 0.25 * t2)
    CL, CD = 4.5 * ca.sin(a) * ca.cos(a) - 0.5 * z, 0.15 + 0.9 * ca.sin(a) ** 2
    sa, cA = ca.sin(alpha), ca.cos(alpha)
    thrust = 0.25 * (1 + 0.3 * pl + 0.2 * (s[0] + s[1]))
    F = ca.vertcat(q * (CL * sa - CD * cA) + thrust, -0.8 * q * slip, q * (-CL * cA - CD * sa))
    M = ca.vertcat(
        q * b * (0.08 * (t1 - t2) * (1 + 0.5 * pl) - 0.15 * b * w[0] / V),
        q * c * (0.25 * (ca.tanh(s[2]) + 0.5 * s[3] * pl) - 0.30 * alpha - 1.5 * c * w[1] / V + 0.05 * pl),
        q * b * (0.06 * (s[3] - s[2] * pl * 0.5) + 0.05 * slip - 0.10 * b * w[2] / V),
    )
    sp, cp, st, ct = ca.sin(att[0]), ca.cos(att[0]), ca.sin(att[1]), ca.cos(att[1])
    Jw = ca.vertcat(J[0] * w[0], J[1] * w[1], J[2] * w[2])
    dv = F / m - ca.cross(w, v) + g * ca.vertcat(-st, sp * ct, cp * ct)
    dw = (M - ca.cross(w, Jw)) / ca.vertcat(*J)
    turn = sp * w[1] + cp * w[2]
    datt = ca.vertcat(w[0] + st / ct * turn, cp * w[1] - sp * w[2], turn / ct)
    lag = -(2 * V / c) * 0.0455 * z + 0.165 * (2 * V / c) * (a - z)
    return ca.vertcat(datt, dw, dv, (u - s) / tau, lag)


def problem():
    """Stage by stage w = [x_0, u_0, x_1, ..], p = [t0, xbar, roll references]."""
    t, x, u = ca.SX.sym("t"), ca.SX.sym("x", NX), ca.SX.sym("u", NU)
    f = ca.Function("f", [t, x, u], [rates(t, x, u)])
    xs = [ca.SX.sym(f"x{k}", NX) for k in range(N + 1)]
    us = [ca.SX.sym(f"u{k}", NU) for k in range(N + 1)]
    p = ca.SX.sym("p", 1 + NX + N)
    fs = [f(p[0] + k * H, xs[k], us[k]) for k in range(N + 1)]
    w, lbx, ubx, g, lbg, ubg, J, equal = [], [], [], [], [], [], 0, []
    for k in range(N + 1):
        w += [xs[k], us[k]]
        box = np.full(NX, np.inf)
        if k > 0:
            box[9:13] = 1.0
        lbx += [*(-box), *[-1] * NU]
        ubx += [*box, *[1] * NU]
        J += 1e-3 * ca.sumsqr(us[k])
        if k < N:
            xc = (xs[k] + xs[k + 1]) / 2 + H / 8 * (fs[k] - fs[k + 1])
            fc = f(p[0] + (k + 0.5) * H, xc, (us[k] + us[k + 1]) / 2)
            g.append(xs[k + 1] - xs[k] - H / 6 * (fs[k] + 4 * fc + fs[k + 1]))
            lbg, ubg, equal = lbg + [0] * NX, ubg + [0] * NX, equal + [True] * NX
            J += 1e-2 * ca.sumsqr(us[k + 1] - us[k])
        if k == 0:
            g.append(xs[0] - p[1 : 1 + NX])
            lbg, ubg, equal = lbg + [0] * NX, ubg + [0] * NX, equal + [True] * NX
        else:
            g.append(ca.vertcat(xs[k][9] - xs[k][10], xs[k][11] - xs[k][12]))
            lbg, ubg, equal = lbg + [-1.2] * 2, ubg + [1.2] * 2, equal + [False] * 2
            J += 100 * ((xs[k][0] - p[NX + k]) ** 2 + (xs[k][1] + 15 * DEG) ** 2) + 0.1 * ca.sumsqr(xs[k][3:6])
    nlp = dict(x=ca.vertcat(*w), p=p, f=J, g=ca.vertcat(*g))
    return nlp, dict(lbx=lbx, ubx=ubx, lbg=lbg, ubg=ubg), equal


def solvers(folder):
    nlp, bounds, equal = problem()
    quiet = dict(print_time=False, record_time=True, error_on_fail=False)
    ipopt = dict(quiet, ipopt=dict(print_level=0, sb="yes", tol=1e-8))
    source = ca.nlpsol("solver", "ipopt", nlp, ipopt)
    os.makedirs(folder, exist_ok=True)
    here = os.getcwd()
    os.chdir(folder)
    source.generate_dependencies("nlp.c")
    subprocess.check_call(["cc", "-O3", "-march=native", "-fPIC", "-shared", "nlp.c", "-o", "nlp.so"])
    found = {"CasADi + IPOPT, generated C": ca.nlpsol("solver", "ipopt", os.path.abspath("nlp.so"), ipopt)}
    os.chdir(here)
    for qp, options in {
        "piqp": {},
        "qrqp": dict(print_iter=False, print_header=False, print_info=False),
        "osqp": dict(osqp=dict(verbose=False)),
    }.items():
        if ca.has_conic(qp):
            sqp = dict(quiet, qpsol=qp, qpsol_options=dict(options, error_on_fail=False), max_iter=1)
            sqp |= dict(print_header=False, print_iteration=False, print_status=False)
            found[f"CasADi sqpmethod + {qp}, one iteration"] = ca.nlpsol("solver", "sqpmethod", nlp, sqp)
    return found, bounds


def main():
    worker, table, folder, repeats = sys.argv[1:]
    rows = np.genfromtxt(table, delimiter=",", skip_header=2)
    found, bounds = solvers(folder)
    process = subprocess.Popen([worker], stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True)

    def ours(instance, iterations):
        process.stdin.write(f"{instance} {iterations}\n")
        process.stdin.flush()
        numbers = [float(n) for n in process.stdout.readline().split()]
        return numbers[0], np.array(numbers[1:])

    names = ["wingbeat, one iteration", "wingbeat, converged", *found]
    times = {name: np.full(len(rows), np.inf) for name in names}
    errors = {name: np.zeros(len(rows)) for name in names}
    inputs = np.concatenate([np.arange(k * (NX + NU) + NX, (k + 1) * (NX + NU)) for k in range(N + 1)])
    for _ in range(int(repeats)):
        for i, row in enumerate(rows):
            best = row[20:44]
            guess = np.concatenate([np.concatenate([row[1:15], np.zeros(NU)])] * (N + 1))
            for name, iterations in [("wingbeat, one iteration", 1), ("wingbeat, converged", 20)]:
                microseconds, u = ours(i, iterations)
                times[name][i] = min(times[name][i], microseconds)
                errors[name][i] = np.abs(u - best).max()
            for name, solver in found.items():
                answer = solver(x0=guess, p=row[:20], **bounds)
                times[name][i] = min(times[name][i], 1e6 * solver.stats()["t_proc_total"])
                errors[name][i] = np.abs(np.array(answer["x"]).ravel()[inputs] - best).max()
    process.stdin.close()
    rows = [
        dict(
            solver=name,
            median_us=float(np.median(times[name])),
            p99_us=float(np.percentile(times[name], 99)),
            input_error_median=float(np.median(errors[name])),
            input_error_max=float(errors[name].max()),
        )
        for name in names
    ]
    print(json.dumps(dict(casadi=ca.__version__, numpy=np.__version__, rows=rows), indent=1))


if __name__ == "__main__":
    main()
