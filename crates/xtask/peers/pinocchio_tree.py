"""Time of Pinocchio's forward dynamics of the reference tree, in one batched call.

Prints `name<TAB>seconds`. The batch loops in C++, so that Python's own time is shared by
a thousand evaluations.
"""

import sys
import time

import numpy as np
import pinocchio as pin

BATCH = 1000
REPEATS = 101


def main(folder):
    model = pin.buildModelFromUrdf(f"{folder}/aerobat10.urdf", pin.JointModelFreeFlyer())
    q, v, tau = (np.loadtxt(f"{folder}/ref_{name}.txt") for name in ("q", "v", "tau"))
    random = np.random.default_rng(1)
    rates = v[:, None] * random.uniform(0.5, 1.5, (model.nv, BATCH))
    poses = np.stack([pin.integrate(model, q, 0.01 * rates[:, k]) for k in range(BATCH)], axis=1)
    torques = np.repeat(tau[:, None], BATCH, axis=1)
    poses, rates, torques = (np.asfortranarray(a) for a in (poses, rates, torques))
    out = np.zeros((model.nv, BATCH), order="F")
    pool = pin.ModelPool(model, 1)
    times = []
    for _ in range(REPEATS):
        start = time.process_time()
        pin.abaInParallel(1, pool, poses, rates, torques, out)
        times.append(time.process_time() - start)
    alone = pin.aba(model, model.createData(), poses[:, 7].copy(), rates[:, 7].copy(), torques[:, 7].copy())
    assert np.allclose(out[:, 7], alone, rtol=1e-12)
    print(f"forward_dynamics\t{sorted(times)[REPEATS // 2] / BATCH}")


main(sys.argv[1])
