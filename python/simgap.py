"""simgap from Python: run a command, read what it leaves, as numpy arrays (python3-numpy).

    import simgap
    fit = simgap.run("fit-spring", {"deflection_m": x, "force_N": f})     # arrays instead of a file
    fit.value("stiffness"), fit.sd("stiffness"), fit.table("errors.csv")["error_N"]

    arm = simgap.run("calibrate", "arm.yaml", poses="poses.csv", optimizer="lm")
    poses = simgap.equilibria(arm.path / "model.yaml", shafts)            # joint angles for commands

The functions above call the program `simgap` (SIMGAP, or the one on the PATH) and know nothing that its files do not
say (docs/formats.md), so that they fit every version of them. Where the compiled module `_simgap` was built, too, there
are arrays without files in between (help(simgap.Arm), help(simgap.fit_spring)):

    arm = simgap.Arm("arm.yaml")
    arm.rest(shafts)["joints"]["elbow"]                                   # shape (poses), of shafts (poses, muscles)
    simgap.fit_spring({"deflection_m": x, "force_N": f})["values"]        # likewise fit_friction, fit_motor, fit_pam

These judge nothing on rows held out, and write nothing: that is what `run` is for.
"""
import csv
import dataclasses
import gzip
import io
import json
import os
import pathlib
import subprocess
import tempfile

import numpy

EXIT_CODES = {1: "a criterion failed", 2: "usage", 3: "wrong data", 4: "the numerics failed", 70: "a bug in simgap",
              130: "interrupted"}


class Error(RuntimeError):
    """A command that failed: `code` as docs/formats.md lists them, the sentence as text."""

    def __init__(self, code, sentence):
        super().__init__(sentence or EXIT_CODES.get(code, f"exit code {code}"))
        self.code = code


def read_table(file):
    """A CSV file (gzip by its name's ending) as column -> array, shape (rows): of float where all cells are numbers or
    empty (NaN), else of str."""
    file = pathlib.Path(file)
    content = gzip.decompress(file.read_bytes()) if file.suffix == ".gz" else file.read_bytes()
    header, *rows = csv.reader(io.StringIO(content.decode()))
    return {name: _column([row[c] for row in rows]) for c, name in enumerate(header)}


def _column(cells):
    try:
        return numpy.array([float(cell) if cell else numpy.nan for cell in cells])
    except ValueError:
        return numpy.array(cells)


def write_table(columns):
    """Columns, name -> values of one length, as the text of a CSV file. Numbers read back exactly."""
    values = [numpy.asarray(column).ravel() for column in columns.values()]
    if len({column.size for column in values}) > 1:
        raise ValueError(f"found columns of {sorted({column.size for column in values})} rows, expected one length")
    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow(columns)
    writer.writerows(zip(*[[repr(float(v)) if column.dtype.kind in "fiu" else str(v) for v in column] for column in values]))
    return text.getvalue()


@dataclasses.dataclass
class Result:
    """What a run has left in its directory."""

    path: pathlib.Path

    def __post_init__(self):
        self.path = pathlib.Path(self.path)
        self.json = json.loads((self.path / "result.json").read_text())

    def table(self, name):
        return read_table(self.path / name)

    def parameter(self, name):
        """The entry of result.json: value, sd, unit …"""
        for parameter in self.json["parameters"]:
            if parameter["name"] == name:
                return parameter
        raise KeyError(f"{name}: expected one of {', '.join(p['name'] for p in self.json['parameters'])}")

    def value(self, name):
        return self.parameter(name)["value"]

    def sd(self, name):
        return self.parameter(name)["sd"]

    @property
    def parameters(self):
        """Names, values and standard deviations, shape (parameters)."""
        listed = self.json["parameters"]
        number = lambda key: numpy.array([numpy.nan if p[key] is None else p[key] for p in listed])
        return numpy.array([p["name"] for p in listed]), number("value"), number("sd")

    @property
    def report(self):
        return self.path / "report.html"


def run(command, *arguments, output=None, **options):
    """Runs `simgap COMMAND ARGUMENTS --option value` and reads its result.

    arguments: files; one of them may be a table of arrays (name -> values), which goes to standard input.
    options: as on the command line, with _ for -: True for a flag, a list for one that may be repeated. A table of
    arrays is taken for a file here, too.
    output: the result directory; by default a new temporary one. An existing result there is replaced.
    Raises Error. A criterion that fails (exit code 1) is a result, too: look into `json`."""
    output = pathlib.Path(output or tempfile.mkdtemp(prefix="simgap-") + "/result")
    tables = []

    def word(value):
        if not isinstance(value, dict):
            return str(value)
        tables.append(write_table(value))
        return "-"

    words = [os.environ.get("SIMGAP", "simgap"), *command.split(), *map(word, arguments), "-q", "--force", "-o", str(output)]
    for name, value in options.items():
        flag = "--" + name.replace("_", "-")
        for one in value if isinstance(value, (list, tuple)) else [value]:
            words += [flag] if one is True else [] if one is False or one is None else [flag, word(one)]
    if len(tables) > 1:
        raise ValueError("found several tables of arrays, expected at most one: write the others to files")
    done = subprocess.run(words, input="".join(tables), capture_output=True, text=True, check=False)
    if done.returncode not in (0, 1) or not (output / "result.json").exists():
        raise Error(done.returncode, done.stderr.strip())
    return Result(output)


def _relative(parent, child):
    """Rotations child in parent from two sets of quaternions w, x, y, z, shape (n, 4)."""
    w, x, y, z = (parent * [1, -1, -1, -1]).T
    a, b, c, d = child.T
    q = numpy.stack([w * a - x * b - y * c - z * d, w * b + x * a + y * d - z * c, w * c - x * d + y * a + z * b,
                     w * d + x * c - y * b + z * a], axis=1)
    return numpy.where(q[:, :1] < 0, -q, q)


def frames(result, state="simulated"):
    """Where the bodies of an arm are in each pose, in the world: body -> array, shape (poses, 7): x, y, z [m], then
    w, x, y, z. Poses that did not come to rest are missing: `pose_names` says which are there."""
    table = result.table("arm_bodies.csv")
    shown = table["state"] == state
    rows = numpy.stack([table[name] for name in ("x_m", "y_m", "z_m", "qw", "qx", "qy", "qz")], axis=1)
    return {body: rows[shown & (table["body"] == body)] for body in dict.fromkeys(table["body"])}


def pose_names(result, state="simulated"):
    table = result.table("arm_bodies.csv")
    return list(dict.fromkeys(table["pose"][table["state"] == state].astype(str)))


def equilibria(model, poses, evaluator="equilibrium"):
    """Where an arm comes to rest for commanded shafts.

    model: an arm (YAML).  poses: a pose set (CSV), or its columns as arrays; of the joints only the columns have to be
    there.  Returns pose names, and body -> rotation in the body before it in the file, shape (poses, 4), w, x, y, z."""
    found = run("validate", model, poses=poses, evaluator=evaluator)
    bodies = list(frames(found).items())
    rotations = {name: _relative(before[:, 3:], at[:, 3:]) for (_, before), (name, at) in zip(bodies, bodies[1:])}
    return pose_names(found), rotations


_COMPILED = ("Arm", "LibraryError", "fit_friction", "fit_motor", "fit_pam", "fit_spring")


def __getattr__(name):
    """What the compiled module has, loaded when it is first asked for."""
    if name not in _COMPILED:
        raise AttributeError(f"module 'simgap' has no attribute '{name}'")
    try:
        import _simgap
    except ImportError as error:
        raise ImportError(f"simgap.{name} needs the compiled module _simgap, built where python3-pybind11 is: {error}") from error
    return getattr(_simgap, name)
