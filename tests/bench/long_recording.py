#!/usr/bin/env python3
"""A long recording of a short one: its pairs to and fro as links, with times at 60 Hz and shafts.

    tests/bench/long_recording.py data/capture 100000 long
"""
import csv
import itertools
import os
import sys

RATE_HZ = 60.0

recording, pairs, folder = sys.argv[1], int(sys.argv[2]), sys.argv[3]
sides = {side: sorted(os.listdir(os.path.join(recording, side))) for side in ("left", "right")}
with open(os.path.join(recording, "shafts.csv"), newline="") as file:
    header, *shafts = csv.reader(file)
count = len(sides["left"])
to_and_fro = itertools.cycle([*range(count), *reversed(range(count))])

for side in sides:
    os.makedirs(os.path.join(folder, side))
with open(os.path.join(folder, "timestamps.csv"), "w") as times, open(os.path.join(folder, "shafts.csv"), "w") as log:
    times.write("time_s\n")
    log.write(",".join(header) + "\n")
    for number, taken in zip(range(pairs), to_and_fro):
        for side, names in sides.items():
            image = os.path.join(recording, side, names[taken])
            os.symlink(os.path.abspath(image), os.path.join(folder, side, f"{number:06}" + os.path.splitext(image)[1]))
        times.write(f"{number / RATE_HZ:.6f}\n")
        log.write(",".join([f"{number / RATE_HZ:.6f}", *shafts[taken][1:]]) + "\n")
