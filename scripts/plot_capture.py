#!/usr/bin/python3
"""A capture: joint angles with the steady windows, visible markers and fit of every target (needs python3-matplotlib).

    scripts/plot_capture.py runs/capture -o capture.pdf
"""
import math

import plotting


def joint_angles(table, joint, kind):
    """Degrees; of a spherical joint the angle from its zero pose."""
    if kind == "revolute":
        return [math.degrees(angle) for angle in table[joint + "_rad"]]
    return [math.degrees(2 * math.acos(min(abs(w), 1.0))) for w in table[joint + "_qw"]]


def draw(run):
    joints, frames = run.table("joints.csv"), run.table("frames.csv")
    figure, (angles, visible, fit, histogram) = plotting.panels(4, columns=2)
    for joint, kind in run.result["joint_types"].items():
        angles.plot(joints["time_s"], joint_angles(joints, joint, kind), linewidth=0.8, label=joint)
    for pose in run.result["poses"]:
        angles.axvspan(pose["start_s"], pose["end_s"], color="0.85", linewidth=0)
    angles.set(xlabel="time [s]", ylabel="angle [deg]")
    for target in frames.distinct("target"):
        part = frames.where("target", target)
        visible.plot(part["time_s"], part["visible"], drawstyle="steps-mid", linewidth=0.8, label=target)
        fit.plot(part["time_s"], part["rms_mm"], linewidth=0.8, label=target)
        histogram.hist(part["rms_mm"], bins=30, histtype="step", label=target)
    visible.set(xlabel="time [s]", ylabel="visible markers")
    fit.set(xlabel="time [s]", ylabel="fit RMS [mm]")
    histogram.set(xlabel="fit RMS [mm]", ylabel="frames")
    for axes in (angles, visible, fit, histogram):
        axes.legend()
    return figure


if __name__ == "__main__":
    plotting.main(__doc__, draw, "capture.pdf")
