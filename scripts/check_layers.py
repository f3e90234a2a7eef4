#!/usr/bin/env python3
"""Fails when a file includes a room it may not know (docs/architecture.md).

Data flows measure -> model -> exchange -> simulate -> fit -> diagnose -> intervene -> report -> cli: a room may include
only what stands to its left, and no room below another family's. capture stands beside these rooms: it needs core alone. tests/reality may
include nothing of the project but core, because the data it makes judges the models. Fails, too, when one room holds more than LARGEST of all lines.
"""
import pathlib
import re
import sys

ROOMS = ["core", "optimize", "capture", "decode", "measure", "model", "exchange", "simulate", "fit", "diagnose",
         "intervene", "report", "cli"]
LARGEST = 0.16
# Families inside a room that know nothing of each other.
APART = [("fit/poses", "fit/actuators"), ("fit/motions", "fit/actuators"), ("fit/dynamics", "fit/poses"),
        ("fit/dynamics", "fit/motions"), ("diagnose/poses", "diagnose/logs"), ("diagnose/motions", "diagnose/logs"),
        ("diagnose/motions", "diagnose/robots"), ("diagnose/poses", "diagnose/robots"), ("intervene/poses", "intervene/logs"),
        ("intervene/motions", "intervene/logs"),
        ("model/arm", "model/friction"), ("exchange", "model/friction"), ("exchange", "model/actuator"),
        ("report/poses", "report/actuators"), ("report/capture", "report/actuators"),
        ("report/diagnosis", "report/actuators")]
# Images become joint angles without a model, and nothing that models or fits sees an image.
APART += [("capture", room) for room in ("optimize", "measure", "model", "exchange", "simulate", "fit", "diagnose", "intervene")]
# What a head says is decoded without a robot.
APART += [("decode", room) for room in ("capture", "measure", "model", "exchange", "simulate", "fit", "diagnose", "intervene")]
# What a room's families share never includes one of them.
SHARED = {"diagnose": ["poses", "logs", "motions", "robots"], "intervene": ["poses", "logs", "motions"],
          "report/html": ["../poses", "../actuators", "../capture", "../diagnosis"]}
# A header in src belongs to its room; these read another one's.
READS = {"intervene": "diagnose"}
INCLUDE = re.compile(r'^\s*#\s*include\s*["<](simgap/)?([\w/]+)/\w+\.h[">]')


def includes(file):
    """Line, room ("fit/poses"), and whether it is a header in src, of every file of the project that this one includes."""
    for number, line in enumerate(file.read_text(encoding="utf-8").splitlines(), 1):
        match = INCLUDE.match(line)
        if match and match.group(2).split("/")[0] in ROOMS:
            yield number, match.group(2), not match.group(1)


def below(room, place):
    return room == place or room.startswith(place + "/")


def refusal(room, target):
    """Why `room` may not include `target`; empty when it may."""
    if ROOMS.index(target.split("/")[0]) > ROOMS.index(room.split("/")[0]):
        return f"{room} may not include {target}"
    for pair in APART:
        for one, other in (pair, pair[::-1]):
            if below(room, one) and below(target, other):
                return f"{room} and {target} know nothing of each other"
    for shared, families in SHARED.items():
        places = [str(pathlib.PurePosixPath(shared).parent / f[3:]) if f.startswith("../") else f"{shared}/{f}" for f in families]
        if room == shared and any(below(target, place) for place in places):
            return f"{room} is shared and may not include {target}"
    return ""


def violations(root):
    for base in ("src", "include/simgap"):
        for file in sorted((root / base).rglob("*.[ch]*")):
            room = file.parent.relative_to(root / base).as_posix()
            own = room.split("/")[0]
            for number, target, private in includes(file):
                if why := refusal(room, target):
                    yield f"{file.relative_to(root)}:{number}: {why}"
                elif private and target.split("/")[0] not in (own, READS.get(own)):
                    yield f"{file.relative_to(root)}:{number}: a header in src/{target} belongs to its room"
    for file in sorted((root / "tests/reality").rglob("*.[ch]*")):
        for number, target, _ in includes(file):
            if target != "core":
                yield f"{file.relative_to(root)}:{number}: tests/reality may not include {target}"


def too_large(root):
    """A room of more than LARGEST of all lines is two rooms (docs/architecture.md)."""
    lines = {room: sum(len(file.read_text(encoding="utf-8").splitlines()) for base in ("src", "include/simgap")
                       for file in (root / base / room).rglob("*.[ch]*") if file.is_file()) for room in ROOMS}
    room, share = max(((room, count / max(1, sum(lines.values()))) for room, count in lines.items()), key=lambda r: r[1])
    if share > LARGEST:
        yield f"{room} has {share:.1%} of the lines, at most {LARGEST:.0%}"


def main():
    root = pathlib.Path(sys.argv[1] if len(sys.argv) > 1 else ".").resolve()
    found = list(violations(root)) + list(too_large(root))
    for line in found:
        print(line)
    print(f"{len(found)} layer violations")
    return 1 if found else 0


if __name__ == "__main__":
    sys.exit(main())
