"""The paper's problem of section IV on the robot, solved by IPOPT on the functions and exact derivatives of this program.

    pip install casadi && cargo build --release --workspace --examples && \\
    python validation/paper_nlp/serve.py target/release/examples/serve_paper_nlp > validation/paper_nlp/robot.csv

`scenarios/paper_plan.toml` on its first mesh, from its first guess. IPOPT is that of the wheel of CasADi, by its C interface.
"""

import ctypes as c
import glob
import os
import subprocess
import sys

import casadi
import numpy as np

library = c.CDLL(glob.glob(os.path.join(os.path.dirname(casadi.__file__), "libipopt.so*"))[0])
DOUBLES, INTS = c.POINTER(c.c_double), c.POINTER(c.c_int)
EVAL_F = c.CFUNCTYPE(c.c_bool, c.c_int, DOUBLES, c.c_bool, DOUBLES, c.c_void_p)
EVAL_GRAD_F = EVAL_F
EVAL_G = c.CFUNCTYPE(c.c_bool, c.c_int, DOUBLES, c.c_bool, c.c_int, DOUBLES, c.c_void_p)
EVAL_JAC_G = c.CFUNCTYPE(
    c.c_bool, c.c_int, DOUBLES, c.c_bool, c.c_int, c.c_int, INTS, INTS, DOUBLES, c.c_void_p
)
EVAL_H = c.CFUNCTYPE(
    c.c_bool, c.c_int, DOUBLES, c.c_bool, c.c_double, c.c_int, DOUBLES, c.c_bool, c.c_int, INTS, INTS, DOUBLES, c.c_void_p
)


class Served:
    """The program behind the pipes."""

    def __init__(self, path):
        self.process = subprocess.Popen([path], stdin=subprocess.PIPE, stdout=subprocess.PIPE)
        self.n, self.m, jacobian, hessian = self.take(4, "<u8")
        self.variables = self.take(2 * self.n).reshape(-1, 2)
        self.constraints = self.take(2 * self.m).reshape(-1, 2)
        self.start = self.take(self.n)
        self.jacobian = self.take(2 * jacobian, "<u8").reshape(-1, 2).astype(np.intc)
        self.hessian = self.take(2 * hessian, "<u8").reshape(-1, 2).astype(np.intc)
        self.last = {}
        self.evaluations = 0

    def take(self, count, kind="<f8"):
        data = self.process.stdout.read(8 * int(count))
        if len(data) < 8 * int(count):
            sys.exit("the program ended")
        return np.frombuffer(data, kind)

    def ask(self, letter, *numbers):
        key = letter + b"".join(np.ascontiguousarray(x, "<f8").tobytes() for x in numbers)
        if self.last.get(letter) == key:
            return self.last[letter + b"a"]
        self.process.stdin.write(key)
        self.process.stdin.flush()
        self.evaluations += 1
        parts = None
        if self.take(1)[0] == 1.0:
            sizes = [1, self.m] if letter == b"e" else [self.n, len(self.jacobian), len(self.hessian)]
            parts = [self.take(size) for size in sizes]
        self.last[letter], self.last[letter + b"a"] = key, parts
        return parts

    def values(self, x):
        return self.ask(b"e", x)

    def slopes(self, x, weight, multipliers):
        return self.ask(b"d", x, [weight], multipliers)


def array(pointer, count):
    return np.ctypeslib.as_array(pointer, (count,))


def solve(served):
    n, m = int(served.n), int(served.m)
    none = np.zeros(m)

    def eval_f(_n, x, _new, out, _user):
        found = served.values(array(x, n))
        if found is None:
            return False
        out[0] = found[0][0]
        return True

    def eval_grad_f(_n, x, _new, out, _user):
        found = served.slopes(array(x, n), 1.0, none)
        if found is None:
            return False
        array(out, n)[:] = found[0]
        return True

    def eval_g(_n, x, _new, _m, out, _user):
        found = served.values(array(x, n))
        if found is None:
            return False
        array(out, m)[:] = found[1]
        return True

    def entries(places, rows, columns):
        array(rows, len(places))[:] = places[:, 0]
        array(columns, len(places))[:] = places[:, 1]
        return True

    def eval_jac_g(_n, x, _new, _m, count, rows, columns, out, _user):
        if not out:
            return entries(served.jacobian, rows, columns)
        found = served.slopes(array(x, n), 1.0, none)
        if found is None:
            return False
        array(out, count)[:] = found[1]
        return True

    def eval_h(_n, x, _new, weight, _m, multipliers, _newm, count, rows, columns, out, _user):
        if not out:
            return entries(served.hessian, rows, columns)
        found = served.slopes(array(x, n), weight, array(multipliers, m))
        if found is None:
            return False
        array(out, count)[:] = found[2]
        return True

    calls = EVAL_F(eval_f), EVAL_G(eval_g), EVAL_GRAD_F(eval_grad_f), EVAL_JAC_G(eval_jac_g), EVAL_H(eval_h)
    limits = [np.ascontiguousarray(np.clip(v, -2e19, 2e19)) for v in (*served.variables.T, *served.constraints.T)]
    pointers = [v.ctypes.data_as(DOUBLES) for v in limits]
    library.CreateIpoptProblem.restype = c.c_void_p
    problem = c.c_void_p(
        library.CreateIpoptProblem(
            n, pointers[0], pointers[1], m, pointers[2], pointers[3], len(served.jacobian), len(served.hessian), 0, *calls
        )
    )
    library.AddIpoptNumOption(problem, b"tol", c.c_double(1e-9))
    library.AddIpoptIntOption(problem, b"print_level", 0)
    library.AddIpoptIntOption(problem, b"max_iter", 2000)
    library.AddIpoptStrOption(problem, b"sb", b"yes")
    library.AddIpoptStrOption(problem, b"fixed_variable_treatment", b"make_parameter")
    x, objective = np.array(served.start), c.c_double()
    status = library.IpoptSolve(
        problem, x.ctypes.data_as(DOUBLES), None, c.byref(objective), None, None, None, None
    )
    if status != 0:
        sys.exit(f"IPOPT ended with {status} at {objective.value}")
    g = served.values(x)[1]
    violation = max((served.constraints[:, 0] - g).max(), (g - served.constraints[:, 1]).max(), 0.0)
    return objective.value, x, violation


if __name__ == "__main__":
    served = Served(sys.argv[1])
    objective, x, violation = solve(served)
    print(
        f"# scenarios/paper_plan.toml on its first mesh: IPOPT of CasADi {casadi.__version__}, tol 1e-9, exact Hessian,"
        f" largest violation {violation:.1e}; validation/paper_nlp/serve.py"
    )
    print("variables,constraints,objective,final_time")
    final = x[-1]
    print(f"{served.n},{served.m},{objective:.14e},{final:.14e}")
