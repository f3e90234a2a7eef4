#!/usr/bin/python3
"""A notebook in one file: fit a spring from arrays, calibrate the sample arm, ask where it comes to rest.

    PYTHONPATH=python SIMGAP=build/release/simgap python/example.py     (in the repository's root; needs python3-numpy)
"""
import numpy

import simgap

# A cord of 150 N/m that is measured with noise: arrays go in, parameters with standard deviations come out.
random = numpy.random.default_rng(1)
t = numpy.arange(0.0, 60.0, 0.02)
x = 0.02 + 0.03 * numpy.sin(0.5 * t) * numpy.sin(0.06 * t + 0.3)
fit = simgap.run("fit-spring", {"time_s": t, "deflection_m": x, "force_N": 150.0 * x + random.normal(0.0, 0.03, t.size)})
print(f"stiffness {fit.value('stiffness'):.1f} ± {fit.sd('stiffness'):.1f} N/m")

# The sample arm: fitted to 15 poses, judged on 15 others.
arm = simgap.run("calibrate", "data/arm/arm.yaml", poses="data/arm/poses_calibration.csv",
                 validation="data/arm/poses_validation.csv", optimizer="lm")
for joint, error in arm.json["mje_deg"]["validation"]["final"].items():
    print(f"{joint}: {error:.2f} deg on poses that the search never saw")
names, values, deviations = arm.parameters
print(f"{names.size} parameters, {numpy.count_nonzero(deviations < 0.01)} known to a hundredth of their unit")

# Where it comes to rest when the biceps is pulled.
poses = simgap.read_table("data/arm/poses_validation.csv")
poses["shaft_biceps_rad"] = poses["shaft_biceps_rad"] + 2.0
resting, rotations = simgap.equilibria(arm.path / "model.yaml", poses)
elbow = numpy.degrees(2.0 * numpy.arccos(numpy.clip(rotations["forearm"][:, 0], -1.0, 1.0)))
print(f"{len(resting)} poses: the elbow bends to {elbow.min():.0f} … {elbow.max():.0f} deg")
