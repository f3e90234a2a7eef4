#!/usr/bin/env python3
"""Many poses of few: copies of a pose set's rows in turn, with normal noise on every shaft.

    tests/bench/many_poses.py data/arm/poses_calibration.csv 500 > poses.csv
"""
import csv
import random
import sys

NOISE_RAD = 0.05

with open(sys.argv[1], newline="") as file:
    header, *rows = csv.reader(file)
random.seed(1)
writer = csv.writer(sys.stdout, lineterminator="\n")
writer.writerow(header)
for number in range(int(sys.argv[2])):
    row = list(rows[number % len(rows)])
    for i, column in enumerate(header):
        if column == "pose":
            row[i] = f"p{number:03}"
        elif column == "time_s":
            row[i] = str(float(row[i]) + 5000 * (number // len(rows)))
        elif column.startswith("shaft_"):
            row[i] = f"{float(row[i]) + random.gauss(0.0, NOISE_RAD):.9g}"
    writer.writerow(row)
