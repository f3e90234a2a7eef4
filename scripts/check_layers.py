#!/usr/bin/env python3
"""Fails when a file includes a folder to its right: measure -> model -> simulate -> fit -> diagnose -> report -> cli.

Also: tests/reality may include nothing of the project but core, because the data it makes judges the models.
"""
import pathlib
import re
import sys

LAYERS = ["core", "measure", "model", "simulate", "fit", "diagnose", "report", "cli"]
INCLUDE = re.compile(r'^\s*#\s*include\s*["<]simgap/(\w+)/')


def included_folders(file):
    for number, line in enumerate(file.read_text(encoding="utf-8").splitlines(), 1):
        match = INCLUDE.match(line)
        if match:
            yield number, match.group(1)


def violations(root):
    for base in ("src", "include/simgap"):
        for layer, folder in enumerate(LAYERS):
            for file in sorted((root / base / folder).rglob("*.[ch]*")):
                for number, target in included_folders(file):
                    if target not in LAYERS[: layer + 1]:
                        yield f"{file.relative_to(root)}:{number}: {folder} may not include {target}"
    for file in sorted((root / "tests/reality").rglob("*.[ch]*")):
        for number, target in included_folders(file):
            if target != "core":
                yield f"{file.relative_to(root)}:{number}: tests/reality may not include {target}"


def main():
    found = list(violations(pathlib.Path(sys.argv[1] if len(sys.argv) > 1 else ".").resolve()))
    for line in found:
        print(line)
    print(f"{len(found)} layer violations")
    return 1 if found else 0


if __name__ == "__main__":
    sys.exit(main())
