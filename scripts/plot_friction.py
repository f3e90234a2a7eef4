#!/usr/bin/python3
"""A friction fit as figures 10, 12-14 and 16 of the paper show it: effort over time, friction curves per band of load,
maps of error and improvement over velocity and load, with the requirements (needs python3-matplotlib).

    scripts/plot_friction.py runs/friction -o friction.pdf
"""
import matplotlib.colors
import numpy
import plotting


def plot_time(axes, run, laws):
    series = run.table("series.csv")
    axes.plot(series["time_s"], series["measured"], color=plotting.GREY, linewidth=0.8, label="measured")
    for law in laws:
        axes.plot(series["time_s"], series[law], linewidth=0.8, label=law)
    axes.set(xlabel="time [s]", ylabel=plotting.title(run.result["target"]), title="a stretch of the log")
    axes.legend()


def plot_band(axes, curves, band):
    part = curves.where("band", band)
    velocity, friction = curves.like("velocity"), curves.like("friction")
    for name in part.distinct("series"):
        line = part.where("series", name)
        if name == "measured":
            axes.plot(line[velocity], line[friction], ".", color=plotting.GREY, markersize=1, alpha=0.5, rasterized=True, label=name)
        else:
            axes.plot(line[velocity], line[friction], label=name)
    axes.set(xlabel=plotting.title(velocity), ylabel=plotting.title(friction), title="load " + band)
    axes.legend()


def plot_map(figure, axes, maps, value, title, run, diverging=False, logarithmic=False):
    """A value per cell of velocity x load."""
    velocity, load = maps.like("velocity"), maps.like("load")
    xs, ys = sorted(set(maps[velocity])), sorted(set(maps[load]))
    grid = numpy.full((len(ys), len(xs)), numpy.nan)
    for x, y, v in zip(maps[velocity], maps[load], value):
        grid[ys.index(y), xs.index(x)] = v
    most = numpy.nanmax(numpy.abs(grid)) or 1.0
    norm = matplotlib.colors.Normalize(-most, most) if diverging else matplotlib.colors.LogNorm() if logarithmic else None
    mesh = axes.pcolormesh(xs, ys, grid, cmap="RdBu" if diverging else "viridis", norm=norm, shading="nearest")
    figure.colorbar(mesh, ax=axes)
    if run.has("requirements.csv"):
        needed = run.table("requirements.csv")
        for v, l in zip(needed[needed.like("velocity")], needed[needed.like("load")]):
            axes.plot([-v, v, v, -v, -v], [-l, -l, l, l, -l], color="black", linewidth=0.8)
    axes.set(xlabel=plotting.title(velocity), ylabel=plotting.title(load), title=title)


def draw(run):
    laws = [row["model"] for row in run.result["comparison"]]
    curves = run.table("curves.csv") if run.has("curves.csv") else None
    bands = curves.distinct("band") if curves else []
    maps = run.table("maps.csv")
    errors = [maps[f"mean_abs_error_{law}"] for law in laws]
    figure, axes = plotting.panels(1 + len(bands) + 1 + len(laws))
    plot_time(axes[0], run, laws)
    for axis, band in zip(axes[1:], bands):
        plot_band(axis, curves, band)
    rest = axes[1 + len(bands):]
    plot_map(figure, rest[0], maps, maps["rows"], "rows", run, logarithmic=True)
    plot_map(figure, rest[1], maps, errors[0], f"mean absolute error of {laws[0]}", run)
    for axis, law, error in zip(rest[2:], laws[1:], errors[1:]):
        gain = [first - own for first, own in zip(errors[0], error)]
        plot_map(figure, axis, maps, gain, f"improvement of {law} over {laws[0]}", run, diverging=True)
    return figure


if __name__ == "__main__":
    plotting.main(__doc__, draw, "friction.pdf")
