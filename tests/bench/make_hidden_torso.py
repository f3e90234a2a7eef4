#!/usr/bin/env python3
"""Writes poses of the sample torso with something in it that the drawing does not know.

    python3 tests/bench/make_hidden_torso.py tests/reality/torso

Statics, drawing and torso as built are those of make_torso_data.py, an independent minimiser. Files: hidden_pulley.csv
(the line of the right biceps loses a share of its tension, by the direction in which its shaft last moved),
hidden_none.csv.
"""
import math
import random
import sys

import make_torso_data as base

POSES = 40
SECONDS_APART = 20.0


def energy(a, shafts, q):
    placed = base.place(q)
    total = 0.0
    for body, parts in base.PARTS.items():
        for _, _, _, mass, at in parts:
            total -= mass * base.dot(base.GRAVITY, base.add(placed[body][1], base.times(placed[body][0], at)))
    return total + sum(0.5 * (1.0 - m.get('lost', 0.0)) * m['stiffness'] * max(0.0, x) ** 2
                       for m, x in base.stretches(a, shafts, q))


def command(a, before, loss, dice):
    """Shafts, and the rest they lead to from those before."""
    while True:
        shafts = {name: round(dice.uniform(0.0, base.LONGEST_SHAFT) * dice.choice((0.3, 1.0)), 6) for name in a}
        for name, share in loss.items():
            wound = shafts[name] - before[name]
            a[name]['lost'] = share * (0 if abs(wound) < 0.01 else math.copysign(1.0, wound))
        q = base.follow(a, shafts)
        if q and all(x < base.LINEAR * m['rest'] for m, x in base.stretches(a, shafts, q)):
            return shafts, q


def record(arms, losses, dice, file):
    before = {side: {name: 0.0 for name in arms[side]} for side in 'rl'}
    with open(file, 'w') as out:
        out.write(base.columns().replace('pose,', 'pose,time_s,', 1))
        for k in range(POSES):
            shafts, joints = [], []
            for side in 'rl':
                a = arms[side]
                s, q = command(a, before[side], losses.get(side, {}), dice)
                shoulder, elbow = base.stuck(a, s, q, dice)
                before[side] = s
                shafts += [s[m] for m in base.MUSCLES]
                joints += base.quaternion(shoulder) + [elbow]
            out.write(f'h{k:03d},{SECONDS_APART * k:g},' + ','.join(f'{x:.9g}' for x in shafts + joints) + '\n')
            out.flush()


def main():
    base.energy = energy
    dice = random.Random(22)
    truth = {side: base.built(base.arm(1.0 if side == 'r' else -1.0), dice) for side in 'rl'}
    record(truth, {}, random.Random(42), f'{sys.argv[1]}/hidden_none.csv')
    record(truth, {'r': {'biceps': 0.3}}, random.Random(41), f'{sys.argv[1]}/hidden_pulley.csv')


if __name__ == '__main__':
    main()
