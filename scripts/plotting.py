"""What the plot_*.py scripts share: tables of a result directory in, a figure for a paper out."""
import argparse
import csv
import json
import pathlib

import matplotlib

matplotlib.use("svg")  # without a display; the ending of the file decides what is written
import matplotlib.pyplot as plt

COLOURS = ["#0072B2", "#D55E00", "#009E73", "#CC79A7", "#E69F00", "#56B4E9"]  # Okabe & Ito
GREY = "#595959"

plt.rcParams.update({"font.size": 8, "legend.frameon": False, "pdf.fonttype": 42, "svg.hashsalt": "simgap",
                     "axes.prop_cycle": matplotlib.cycler(color=COLOURS)})


class Table:
    """A CSV file by columns: numbers where all cells are numbers or empty (then NaN), else texts."""

    def __init__(self, file):
        with open(file, newline="", encoding="utf-8") as stream:
            header, *rows = csv.reader(stream)
        self.columns = {name: [row[i] for row in rows] for i, name in enumerate(header)}
        self.rows = len(rows)

    def __getitem__(self, name):
        return [float(cell) if cell else float("nan") for cell in self.columns[name]]

    def text(self, name):
        return self.columns[name]

    def like(self, stem):
        """The column that is `stem`, or begins with it and an underscore."""
        return next(name for name in self.columns if name == stem or name.startswith(stem + "_"))

    def where(self, key, value):
        """The rows whose text in `key` is `value`."""
        part = Table.__new__(Table)
        kept = [i for i, text in enumerate(self.columns[key]) if text == value]
        part.columns = {name: [cells[i] for i in kept] for name, cells in self.columns.items()}
        part.rows = len(kept)
        return part

    def distinct(self, name):
        return list(dict.fromkeys(self.columns[name]))


class Run:
    """A result directory."""

    def __init__(self, directory):
        self.directory = directory
        self.result = json.loads((directory / "result.json").read_text(encoding="utf-8"))

    def table(self, name):
        return Table(self.directory / name)

    def has(self, name):
        return (self.directory / name).exists()


UNITS = [("rad_s", "rad/s"), ("deg_s", "deg/s"), ("Nm", "N m"), ("rad2", "rad²"), ("degC", "°C")]


def title(column):
    """"velocity_rad_s" -> "velocity [rad/s]"."""
    for suffix, shown in UNITS:
        if column.endswith("_" + suffix):
            return f"{column[:-len(suffix) - 1].replace('_', ' ')} [{shown}]"
    stem, _, unit = column.rpartition("_")
    return f"{stem.replace('_', ' ')} [{unit}]" if stem and unit in ("A", "N", "V", "Pa", "s", "m", "mm", "deg", "rad") else column.replace("_", " ")


def panels(count, width=3.4, height=2.6, columns=3):
    """A figure of `count` axes in rows of at most `columns`."""
    columns = min(columns, count)
    rows = -(-count // columns)
    figure, axes = plt.subplots(rows, columns, figsize=(width * columns, height * rows), layout="constrained", squeeze=False)
    for extra in axes.flat[count:]:
        extra.remove()
    return figure, list(axes.flat[:count])


def main(description, draw, default):
    """The command line of a script: a run, and where the figure goes (the ending chooses PDF, SVG or PNG)."""
    parser = argparse.ArgumentParser(description=description, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("run", type=pathlib.Path, help="result directory")
    parser.add_argument("-o", "--output", type=pathlib.Path, default=default, help="figure (.pdf, .svg, .png; default: %(default)s)")
    arguments = parser.parse_args()
    figure = draw(Run(arguments.run))
    dated = {".svg": {"Date": None}, ".pdf": {"CreationDate": None}}  # the same figure twice is the same file
    figure.savefig(arguments.output, metadata=dated.get(arguments.output.suffix))
