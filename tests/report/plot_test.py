#!/usr/bin/env python3
"""Every scripts/plot_*.py draws its figure from a result directory, the same file each time.

    tests/report/plot_test.py SIMGAP SOURCE

Exits with 77 (skipped) where Debian's python3-matplotlib is missing.
"""
import json
import pathlib
import subprocess
import sys
import tempfile

import sample_runs

PYTHON = "/usr/bin/python3"  # the one Debian's packages are for
RUNS = {"calibration": ["calibrate"], "validation": ["validate"], "friction": ["fit-friction"], "response": ["fit-motor", "predict"],
        "pam": ["fit-pam"], "spring": ["fit-spring"], "capture": ["capture"], "diagnosis": ["diagnose"]}


# Draws figures in one process that has matplotlib already, a child for each: argv is the folder of the scripts, and of every
# figure the arguments as a list in JSON.
DRAW_ALL = """
import json, os, runpy, sys
sys.path.insert(0, sys.argv[1])
import plotting
for words in map(json.loads, sys.argv[2:]):
    child = os.fork()
    if child == 0:
        sys.argv = words
        runpy.run_path(words[0], run_name="__main__")
        sys.stdout.flush()
        os._exit(0)
    if os.waitpid(child, 0)[1] != 0:
        sys.exit(f"{words}: no figure")
"""


def draw(script, run, figure):
    """As a user draws it."""
    subprocess.run([PYTHON, script, run, "-o", figure], check=True, timeout=120)


def draw_all(folder, figures):
    """Figures of (script, run, file), where loading matplotlib is not paid for again and again."""
    words = [json.dumps([str(script), str(run), "-o", str(figure)]) for script, run, figure in figures]
    subprocess.run([PYTHON, "-c", DRAW_ALL, folder, *words], check=True, timeout=120 * len(figures))


def main(simgap, source):
    if subprocess.run([PYTHON, "-c", "import matplotlib"], capture_output=True).returncode != 0:
        print("skipped: python3-matplotlib not found (scripts/install_dependencies installs it)")
        return 77
    scripts = {path.stem.removeprefix("plot_"): path for path in sorted((source / "scripts").glob("plot_*.py"))}
    assert scripts.keys() == RUNS.keys(), f"scripts without a test, or tests without a script: {scripts.keys() ^ RUNS.keys()}"
    with tempfile.TemporaryDirectory(prefix="simgap-figures-") as temporary:
        folder = pathlib.Path(temporary)
        sample_runs.make(simgap, source, folder, [run for runs in RUNS.values() for run in runs])
        wanted = [(script, name, run) for name, script in scripts.items() for run in RUNS[name]]
        for script, name, run in wanted:
            draw(script, folder / run, folder / f"{run}.pdf")
        draw_all(source / "scripts", [(script, folder / run, folder / f"{run}{ending}") for script, name, run in wanted
                                      for ending in ("-again.pdf", ".svg")])
        for script, name, run in wanted:
            pdf, again = ((folder / f"{run}{ending}").read_bytes() for ending in (".pdf", "-again.pdf"))
            assert pdf.startswith(b"%PDF") and len(pdf) > 5000, f"{name}: an empty figure"
            assert pdf == again, f"{name}: another file the second time"
            assert (folder / f"{run}.svg").read_text().count("<path") > 20, f"{name}: an empty figure"
            print(f"{name} of {run}: {len(pdf)} bytes")
    return 0


if __name__ == "__main__":
    sys.exit(main(pathlib.Path(sys.argv[1]).resolve(), pathlib.Path(sys.argv[2]).resolve()))
