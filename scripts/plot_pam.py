#!/usr/bin/python3
"""Force of a pneumatic muscle over contraction, and what the models miss (needs python3-matplotlib).

    scripts/plot_pam.py runs/pam -o pam.pdf
"""
import plotting


def draw(run):
    forces, errors = run.table("forces.csv"), run.table("errors.csv")
    figure, (left, right) = plotting.panels(2)
    for name in forces.distinct("series"):
        part = forces.where("series", name)
        style = {"marker": ".", "linestyle": "", "color": plotting.GREY, "markersize": 2} if name == "measured" else {}
        left.plot(part["contraction"], part["force_N"], label=name, **style)
    left.set(xlabel="apparent contraction", ylabel="force [N]")
    left.legend(fontsize=6)
    for name in errors.distinct("series"):
        part = errors.where("series", name)
        right.plot(part["force_N"], part["error_N"], ".", markersize=2, label=name)
    right.axhline(0, color="black", linewidth=0.8)
    right.set(xlabel="measured force [N]", ylabel="predicted - measured [N]")
    right.legend()
    return figure


if __name__ == "__main__":
    plotting.main(__doc__, draw, "pam.pdf")
