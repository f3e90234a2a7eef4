#!/usr/bin/env python3
"""Convergence and pose errors of a calibration as a figure for a paper (needs python3-matplotlib).

    scripts/plot_calibration.py runs/arm -o arm.svg
"""
import argparse
import csv
import pathlib

import matplotlib

matplotlib.use("svg")
import matplotlib.pyplot as plt

COLOURS = ["#0072B2", "#D55E00", "#009E73", "#CC79A7"]  # Okabe & Ito


def read(file):
    with open(file, newline="", encoding="utf-8") as stream:
        return list(csv.DictReader(stream))


def plot_convergence(axes, history, joints):
    generations = [int(row["generation"]) for row in history]
    for joint, colour in zip(joints, COLOURS):
        axes.plot(generations, [float(row[f"mje_{joint}_deg"]) for row in history], color=colour, label=joint)
    axes.set(yscale="log", xlabel="generation", ylabel="mean joint error [deg]", title="calibration poses")
    axes.legend(frameon=False)


def plot_errors(axes, errors, joint, colour):
    """Before (light) and after (dark) of every pose; calibration left of the line, validation right."""
    rows = [row for row in errors if row[f"{joint}_error_before_deg"] and row[f"{joint}_error_after_deg"]]
    before = [float(row[f"{joint}_error_before_deg"]) for row in rows]
    after = [float(row[f"{joint}_error_after_deg"]) for row in rows]
    axes.bar(range(len(rows)), before, color=colour, alpha=0.3, label="before")
    axes.bar(range(len(rows)), after, color=colour, label="after")
    calibration = sum(row["set"] == "calibration" for row in rows)
    axes.axvline(calibration - 0.5, color="black", linewidth=0.8)
    axes.text(calibration - 1, axes.get_ylim()[1], "calibration ", ha="right", va="top", fontsize=8)
    axes.text(calibration, axes.get_ylim()[1], " validation", ha="left", va="top", fontsize=8)
    axes.set(title=joint, xlabel="pose", ylabel="joint error [deg]", xticks=[])
    axes.legend(framealpha=1, fontsize=8, loc="center right")


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("run", type=pathlib.Path)
    parser.add_argument("-o", "--output", type=pathlib.Path, default="calibration.svg")
    arguments = parser.parse_args()

    history = read(arguments.run / "history.csv")
    errors = read(arguments.run / "errors.csv")
    joints = [name[4:-4] for name in history[0] if name.startswith("mje_")]
    figure, axes = plt.subplots(1, 1 + len(joints), figsize=(4 * (1 + len(joints)), 3.2), layout="constrained")
    plot_convergence(axes[0], history, joints)
    for axis, joint, colour in zip(axes[1:], joints, COLOURS):
        plot_errors(axis, errors, joint, colour)
    figure.savefig(arguments.output, metadata={"Date": None})


if __name__ == "__main__":
    main()
