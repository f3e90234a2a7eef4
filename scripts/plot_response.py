#!/usr/bin/python3
"""Measured and computed over time: a result of fit-motor, fit-gearbox or predict (needs python3-matplotlib).

    scripts/plot_response.py runs/motor -o motor.pdf
"""
import plotting


def draw(run):
    name, computed = ("response.csv", "simulated") if run.has("response.csv") else ("prediction.csv", "predicted")
    table = run.table(name)
    columns = [column for column in table.columns if f"_{computed}" in column]
    time = table["time_s"] if "time_s" in table.columns else list(range(1, table.rows + 1))
    figure, axes = plotting.panels(len(columns), width=6.0, height=2.2, columns=1)
    for axis, column in zip(axes, columns):
        measured = column.replace(f"_{computed}", "_measured")
        if measured in table.columns:
            axis.plot(time, table[measured], color=plotting.GREY, linewidth=0.8, label="measured")
        axis.plot(time, table[column], linewidth=0.8, label=computed)
        axis.set(xlabel="time [s]" if "time_s" in table.columns else "row", ylabel=plotting.title(column.replace(f"_{computed}", "")))
        axis.legend()
    return figure


if __name__ == "__main__":
    plotting.main(__doc__, draw, "response.pdf")
