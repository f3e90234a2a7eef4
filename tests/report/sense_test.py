#!/usr/bin/env python3
"""Runs every command that writes a result and reads what it says for sense: no NaN, no share above 100 %, no interval
without its estimate, no more independent rows than rows, no time shorter than the wall's, no number without bounds.

    sense_test.py SIMGAP SOURCE [COMMAND…]
"""
import json
import math
import pathlib
import random
import re
import subprocess
import sys
import tempfile
import time

import sample_runs

LARGEST = 1e15  # no quantity of a robot is larger, in any unit that a result uses


def gearbox_log(file):
    """The motor of sample_runs.motor_log behind a gearbox of 20 and under steps of load."""
    noise, rows, current, velocity, dt, ratio = random.Random(5), [], 0.0, 0.0, 1e-4, 20.0
    voltage = load = 0.0
    for i in range(30000):
        if i % 3170 == 0:
            voltage = noise.uniform(-12, 12)
        if i % 5230 == 0:
            load = noise.uniform(-0.05, 0.05)
        current += dt / 3e-4 * (voltage - 0.8 * current - 0.011 * velocity)
        driving = ratio * 0.7 * (0.011 * current - 1e-6 * velocity) - load - 1e-4 * velocity / ratio
        inertia, hold = ratio * 0.7 * 2e-6 + 1e-4 / ratio, ratio * 0.7 * 0.002 + 0.01
        free, stop = velocity + dt * driving / inertia, dt * hold / inertia
        velocity = free - math.copysign(min(stop, abs(free)), free)
        if i % 10 == 0:
            rows.append((i * dt, voltage, current + noise.gauss(0, 0.01), velocity + noise.gauss(0, 0.5), load))
    sample_runs.write_csv(file, "time_s,voltage_V,current_A,velocity_rad_s,load_torque_Nm", rows)


def all_commands(source, folder):
    runs = sample_runs.commands(source, folder)
    gearbox_log(folder / "gearbox.csv")
    runs["fit-gearbox"] = ["fit-gearbox", folder / "gearbox.csv", "--motor", folder / "fit-motor/model.yaml", "--ratio", "20"]
    runs["diagnose-log"] = ["diagnose", "classic", "--log", folder / "friction.csv", "--effects", "inertia,channel-delay,friction-heating"]
    runs["diagnose-poses"] = ["diagnose", source / "data/arm/arm.yaml", "--poses", source / "data/arm/poses_calibration.csv",
                              "--effects", "gravity-tilt,cord-hardening"]
    return runs


def refuse_constant(name):
    raise ValueError(f"found {name}, expected numbers or null")


class Reader:
    """Collects what makes no sense in a result."""

    def __init__(self):
        self.nonsense = []

    def say(self, where, sentence):
        self.nonsense.append(f"{where}: {sentence}")

    def number(self, where, key, value):
        if not math.isfinite(value) or abs(value) > LARGEST:
            self.say(where, f"{value} is no number to deliver")
        if re.search(r"percent|share", key) and value > 100.0 + 1e-9:
            self.say(where, f"{value} % is more than everything")
        if re.search(r"share|explained|explainable", key) and value < 0.0:
            self.say(where, f"{value} % is less than nothing")
        if re.search(r"^(sd|rms|mse|n|wall_s|duration_s)$|_sd$|_rms$|^mse", key) and value < 0.0:
            self.say(where, f"{value} is negative")

    def interval(self, where, entry):
        for value_key, interval_key in (("value", "ci95"), ("gain_heldout_percent", "gain_ci95")):
            value, interval = entry.get(value_key), entry.get(interval_key)
            if not isinstance(value, (int, float)) or not isinstance(interval, list) or None in interval:
                continue
            slack = 1e-9 * max(abs(value), 1e-300)
            if not interval[0] - slack <= value <= interval[1] + slack:
                self.say(where, f"the interval {interval} does not hold its estimate {value}")

    def walk(self, where, key, node):
        if isinstance(node, dict):
            self.interval(where, node)
            rows, independent = node.get("n"), node.get("n_effective")
            if isinstance(rows, (int, float)) and isinstance(independent, (int, float)) and independent > rows * (1 + 1e-9):
                self.say(where, f"{rows} rows are worth {independent} independent ones")
            for name, child in node.items():
                self.walk(f"{where}.{name}", name, child)
        elif isinstance(node, list):
            for i, child in enumerate(node):
                self.walk(f"{where}[{i}]", key, child)
        elif isinstance(node, bool) or node is None:
            return
        elif isinstance(node, (int, float)):
            self.number(where, key, node)
        elif re.search(r"(^|[\s(±])[-+]?(nan|inf)\b|e\+\d{3}|\b\d{16,}\b", node):
            self.say(where, f"'{node}' holds a number that is none")

    def times(self, folder, begin):
        run = json.loads((folder / "run.json").read_text(), parse_constant=refuse_constant)
        # A run's time is taken between two of its files, however busy the machine is behind them. The system counts a
        # process's start in ticks of 10 ms.
        least, most = ((folder / file).stat().st_mtime - begin for file in ("result.json", "run.json"))
        if not 0.9 * least - 0.1 <= run["duration_s"] <= most + 0.05:
            self.say("run.json", f"took {run['duration_s']:.3f} s, and {least:.3f} to {most:.3f} s by the clock on the wall")
        if run["status"] != "done":
            self.say("run.json", f"status {run['status']} with exit code 0")


def judge(folder, begin):
    reader = Reader()
    result = json.loads((folder / "result.json").read_text(), parse_constant=refuse_constant)
    reader.walk("result.json", "", result)
    reader.times(folder, begin)
    hypotheses = folder / "hypotheses.csv"
    if hypotheses.exists():
        header, *lines = [line.split(",") for line in hypotheses.read_text().splitlines()]
        gains = [line[header.index("gain_percent")] for line in lines]
        if len(gains) > 3 and sum(gain in ("0", "-0") for gain in gains) > len(gains) / 2:
            reader.say("hypotheses.csv", f"most of {len(gains)} gains are exactly 0: they were never measured")
    return reader.nonsense


def check_the_judge():
    """The judge sees what it is there for."""
    reader = Reader()
    reader.walk("r", "", {"n": 10, "n_effective": 11.0, "share_percent": 158.0, "sd": -1.0, "text": "RMS nan A", "k_a": 1e300,
                          "p": {"value": 3.0, "ci95": [1.0, 2.0]}})
    assert len(reader.nonsense) == 6, reader.nonsense
    reader = Reader()
    reader.walk("r", "", {"n": 10, "n_effective": 10.0, "share_percent": 100.0, "text": "information about what infants nanny",
                          "p": {"value": 1.5, "ci95": [1.0, 2.0]}, "q": {"value": None, "ci95": [None, None]}})
    assert not reader.nonsense, reader.nonsense


def main():
    simgap, source = pathlib.Path(sys.argv[1]), pathlib.Path(sys.argv[2])
    wanted = sys.argv[3:]
    check_the_judge()
    failures = []
    with tempfile.TemporaryDirectory() as name:
        folder = pathlib.Path(name)
        for command, arguments in all_commands(source, folder).items():
            if wanted and command not in wanted:
                continue
            begin = time.time()
            done = subprocess.run([simgap, *arguments, "-q", "-o", folder / command], capture_output=True, text=True)
            if done.returncode != 0:
                failures.append(f"{command}: exit code {done.returncode}: {done.stderr.strip()}")
                continue
            nonsense = judge(folder / command, begin)
            print(f"{command}: {len(nonsense)} of its statements make no sense")
            failures += [f"{command}: {sentence}" for sentence in nonsense]
    print("\n".join(failures))
    return 1 if failures else 0


if __name__ == "__main__":
    sys.exit(main())
