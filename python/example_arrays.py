#!/usr/bin/python3
"""A notebook in one file, without files in between: an arm's workspace from its energy, checked by simulation, and how a
fit's interval holds when noise is drawn again.

    PYTHONPATH=python:build/dev python/example_arrays.py     (in the repository's root; needs python3-numpy and _simgap)
"""
import numpy

import simgap

# Where the sample arm rests while the biceps winds up: 40 equilibria in one call.
arm = simgap.Arm("data/arm/arm.yaml")
start = arm.read_poses("data/arm/poses_validation.csv")["shafts"][14]
shafts = numpy.tile(start, (40, 1))
shafts[:, arm.muscles.index("biceps")] += numpy.linspace(0.0, 4.0, 40)
resting = arm.rest(shafts)
elbow = numpy.degrees(resting["joints"]["elbow"])
place = resting["origins"][:, arm.bodies.index("forearm")]
print(f"the elbow bends from {elbow[0]:.0f} to {elbow[-1]:.0f} deg, its place moves {numpy.ptp(place, axis=0).max() * 1e3:.0f} mm")

# The same poses by simulation, which has friction in the joints: how far it stops short.
simulated = arm.rest(shafts[::10], evaluator="bullet")
short = numpy.degrees(simulated["joints"]["elbow"]) - elbow[::10]
print(f"simulated: {simulated['status'].count('steady')} of 4 came to rest, within {numpy.nanmax(numpy.abs(short)):.1f} deg")

# A spring of 150 N/m, fitted to 20 draws of the noise: do intervals of two standard deviations hold the truth?
random = numpy.random.default_rng(1)
t = numpy.arange(0.0, 60.0, 0.05)
x = 0.05 + 0.03 * numpy.sin(0.5 * t) * numpy.sin(0.06 * t + 0.3)
fits = [simgap.fit_spring({"time_s": t, "deflection_m": x, "force_N": 150.0 * x + random.normal(0.0, 0.05, t.size)})
        for _ in range(20)]
at = fits[0]["names"].index("stiffness")
held = sum(abs(fit["values"][at] - 150.0) < 2.0 * fit["sd"][at] for fit in fits)
print(f"{held} of 20 intervals hold the stiffness")
