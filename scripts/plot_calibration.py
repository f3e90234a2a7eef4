#!/usr/bin/python3
"""Convergence, pose errors and parameters of a calibration as a figure for a paper (needs python3-matplotlib).

    scripts/plot_calibration.py runs/arm -o arm.pdf
"""
import plotting

VERDICTS = ["identifiable", "weak", "not identifiable"]


def plot_convergence(axes, history, joints):
    for joint, colour in zip(joints, plotting.COLOURS):
        axes.plot(history["generation"], history[f"mje_{joint}_deg"], color=colour, label=joint)
    axes.set(yscale="log", xlabel="generation", ylabel="mean joint error [deg]", title="calibration poses")
    axes.legend()


def plot_errors(axes, errors, joint, colour):
    """Before (light) and after (dark) of every pose; calibration left of the line, validation right."""
    axes.bar(range(errors.rows), errors[f"{joint}_error_before_deg"], color=colour, alpha=0.3, label="before")
    axes.bar(range(errors.rows), errors[f"{joint}_error_after_deg"], color=colour, label="after")
    calibration = errors.text("set").count("calibration")
    axes.axvline(calibration - 0.5, color="black", linewidth=0.8)
    axes.text(calibration - 1, axes.get_ylim()[1], "calibration ", ha="right", va="top")
    axes.text(calibration, axes.get_ylim()[1], " validation" if calibration < errors.rows else "", ha="left", va="top")
    axes.set(title=joint, xlabel="pose", ylabel="joint error [deg]", xticks=[])
    axes.legend(frameon=True, framealpha=1, loc="center right")


def plot_moved(axes, parameters):
    """How far each parameter went, in standard deviations of its hand measurement; triangles stand at a bound."""
    names = parameters.text("identifiable")
    moved = [(value - initial) / sd for value, initial, sd in zip(parameters["value"], parameters["initial"], parameters["prior_sd"])]
    order = sorted(range(parameters.rows), key=lambda i: moved[i])
    for verdict, colour in zip(VERDICTS, plotting.COLOURS):
        for marker, at_bound in (("o", "false"), ("^", "true")):
            shown = [(place, moved[i]) for place, i in enumerate(order) if names[i] == verdict and parameters.text("at_bound")[i] == at_bound]
            if shown:
                axes.plot(*zip(*shown), marker, color=colour, markersize=3, label=verdict if marker == "o" else None)
    axes.axhline(0, color="black", linewidth=0.8)
    axes.set(title="parameters", xlabel="parameter, sorted", ylabel="change / prior sd", xticks=[])
    axes.legend()


def draw(run):
    history, errors, parameters = run.table("history.csv"), run.table("errors.csv"), run.table("parameters.csv")
    joints = [name[4:-4] for name in history.columns if name.startswith("mje_")]
    known = any(parameters.text("prior_sd"))
    figure, axes = plotting.panels(1 + len(joints) + known, columns=4)
    plot_convergence(axes[0], history, joints)
    for axis, joint, colour in zip(axes[1:], joints, plotting.COLOURS):
        plot_errors(axis, errors, joint, colour)
    if known:
        plot_moved(axes[-1], parameters)
    return figure


if __name__ == "__main__":
    plotting.main(__doc__, draw, "calibration.pdf")
