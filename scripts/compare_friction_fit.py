#!/usr/bin/env python3
"""Times ONE start of SciPy's bounded least squares on the log that `simgap fit-friction` fits (variant A).

    make_friction_log > log.csv && scripts/compare_friction_fit.py log.csv [--seed 1]
"""
import argparse
import time

import numpy as np
from scipy.optimize import least_squares

parser = argparse.ArgumentParser(description=__doc__)
parser.add_argument("log")
parser.add_argument("--seed", type=int, default=1)
arguments = parser.parse_args()

columns = open(arguments.log, encoding="utf-8").readline().strip().split(",")
data = np.loadtxt(arguments.log, delimiter=",", skiprows=1)
current = data[:, columns.index("motor_current_A")]
velocity = data[:, columns.index("motor_velocity_rad_s")]
load = data[:, columns.index("external_torque_Nm")]
direction = np.sign(velocity)


def residual(p):
    k_a, n_c1, n_c2, n_s, k_v, v_s, delta = p
    sliding = n_c1 * np.abs(load) + n_c2
    still = np.exp(-np.abs(velocity / v_s) ** delta)
    friction = (sliding + (n_s * np.abs(load) - sliding) * still) * direction + k_v * velocity
    return (load + friction) / k_a - current


for name, start in (("a random start from 1e-4 to 20", np.random.default_rng(arguments.seed).uniform(1e-4, 20.0, 7)),
                    ("a good guess", np.array([1.0, 0.3, 1.0, 0.3, 0.01, 10.0, 1.0]))):
    begin = time.perf_counter()
    result = least_squares(residual, start, bounds=(1e-9, np.inf))
    seconds = time.perf_counter() - begin
    print(f"{name}: {seconds:.2f} s, {result.nfev} evaluations, MSE {2 * result.cost / len(current):.6f} A^2")
