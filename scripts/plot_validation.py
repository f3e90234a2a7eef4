#!/usr/bin/python3
"""Errors of every pose of a validation, worst first, as a figure for a paper (needs python3-matplotlib).

    scripts/plot_validation.py runs/validation -o validation.pdf
"""
import math

import plotting


def draw(run):
    errors = run.table("errors.csv")
    ending = "_error_deg"
    joints = [name[:-len(ending)] for name in errors.columns if name.endswith(ending)]
    columns = [[0.0 if math.isnan(error) else error for error in errors[joint + ending]] for joint in joints]
    order = sorted(range(errors.rows), key=lambda i: -max(column[i] for column in columns))
    figure, (axes,) = plotting.panels(1, width=max(4.0, 0.22 * errors.rows), height=2.8)
    width = 0.8 / len(joints)
    for j, (joint, column) in enumerate(zip(joints, columns)):
        axes.bar([place + j * width for place in range(len(order))], [column[i] for i in order], width, label=joint)
    axes.set(ylabel="joint error [deg]")
    axes.set_xticks(range(len(order)), [errors.text("pose")[i] for i in order], rotation=90)
    axes.legend()
    return figure


if __name__ == "__main__":
    plotting.main(__doc__, draw, "validation.pdf")
