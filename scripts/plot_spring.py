#!/usr/bin/python3
"""Force of a spring over its deflection, and what the models miss (needs python3-matplotlib).

    scripts/plot_spring.py runs/spring -o spring.pdf
"""
import plotting


def draw(run):
    forces, errors = run.table("forces.csv"), run.table("errors.csv")
    deflection, error = forces.like("deflection"), errors.like("error")
    force = list(forces.columns)[-1]
    figure, (left, right) = plotting.panels(2)
    for name in forces.distinct("series"):
        part = forces.where("series", name)
        style = {"marker": ".", "linestyle": "", "color": plotting.GREY, "markersize": 2} if name == "measured" else {}
        left.plot(part[deflection], part[force], label=name, **style)
    left.set(xlabel=plotting.title(deflection), ylabel=plotting.title(force))
    left.legend()
    for name in errors.distinct("series"):
        part = errors.where("series", name)
        right.plot(part[deflection], part[error], ".", markersize=2, label=name)
    right.axhline(0, color="black", linewidth=0.8)
    right.set(xlabel=plotting.title(deflection), ylabel="predicted - measured " + plotting.title(error).split(" ", 1)[1])
    right.legend()
    return figure


if __name__ == "__main__":
    plotting.main(__doc__, draw, "spring.pdf")
