#!/usr/bin/env python3
"""Every scripts/plot_*.py draws its figure from a result directory, the same file each time.

    tests/report/plot_test.py SIMGAP SOURCE

Exits with 77 (skipped) where Debian's python3-matplotlib is missing.
"""
import pathlib
import subprocess
import sys
import tempfile

import sample_runs

PYTHON = "/usr/bin/python3"  # the one Debian's packages are for
RUNS = {"calibration": ["calibrate"], "validation": ["validate"], "friction": ["fit-friction"], "response": ["fit-motor", "predict"],
        "pam": ["fit-pam"], "spring": ["fit-spring"], "capture": ["capture"], "diagnosis": ["diagnose"]}


def draw(script, run, figure):
    subprocess.run([PYTHON, script, run, "-o", figure], check=True, timeout=120)
    return figure.read_bytes()


def main(simgap, source):
    if subprocess.run([PYTHON, "-c", "import matplotlib"], capture_output=True).returncode != 0:
        print("skipped: python3-matplotlib not found (scripts/install_dependencies installs it)")
        return 77
    scripts = {path.stem.removeprefix("plot_"): path for path in sorted((source / "scripts").glob("plot_*.py"))}
    assert scripts.keys() == RUNS.keys(), f"scripts without a test, or tests without a script: {scripts.keys() ^ RUNS.keys()}"
    with tempfile.TemporaryDirectory(prefix="simgap-figures-") as temporary:
        folder = pathlib.Path(temporary)
        sample_runs.make_all(simgap, source, folder)
        for name, script in scripts.items():
            for run in RUNS[name]:
                pdf, again = (draw(script, folder / run, folder / file) for file in ("one.pdf", "two.pdf"))
                assert pdf.startswith(b"%PDF") and len(pdf) > 5000, f"{name}: an empty figure"
                assert pdf == again, f"{name}: another file the second time"
                svg = draw(script, folder / run, folder / "one.svg").decode()
                assert svg.count("<path") > 20, f"{name}: an empty figure"
                print(f"{name} of {run}: {len(pdf)} bytes")
    return 0


if __name__ == "__main__":
    sys.exit(main(pathlib.Path(sys.argv[1]).resolve(), pathlib.Path(sys.argv[2]).resolve()))
