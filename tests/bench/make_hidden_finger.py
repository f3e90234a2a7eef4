#!/usr/bin/env python3
"""Writes poses of fingers that have something in them that the drawing does not know.

    python3 tests/bench/make_hidden_finger.py tests/reality/finger

Statics, ways over cylinders and numbers of the finger as built are those of make_finger_data.py, an independent
minimiser; what is hidden is written here anew. Files: hidden_none.csv, hidden_pulley.csv (the extensor's line loses a
share of its tension, by the direction in which its shaft last moved), hidden_ligament.csv (the collateral ligament is
longer), hidden_wrap.csv (the band over the last joint lies on a ball about it, and in straight_band.yaml it does not).
"""
import math
import random
import sys

import make_finger_data as base
from make_finger_data import add, dot, norm, sub, times

POSES = 50
SECONDS_APART = 20.0


def over_ball(centre, radius, a, b):
    """Length of a taut string from a to b round a ball; straight where that is free."""
    da, db = sub(a, centre), sub(b, centre)
    way = sub(b, a)
    share = min(1.0, max(0.0, -dot(da, way) / dot(way, way)))
    if norm(add(da, [share * w for w in way])) >= radius or min(norm(da), norm(db)) <= radius:
        return norm(way)
    between = math.acos(max(-1.0, min(1.0, dot(da, db) / (norm(da) * norm(db)))))
    arc = between - math.acos(radius / norm(da)) - math.acos(radius / norm(db))
    return (math.sqrt(dot(da, da) - radius ** 2) + math.sqrt(dot(db, db) - radius ** 2) + radius * max(0.0, arc))


def energy_with(hidden):
    """Energy of a finger with what is hidden in it. hidden: {'loss': {muscle: share}, 'before': {muscle: rad},
    'ball': {tendon: (body of the ball, its centre, radius)}}"""
    def energy(f, shafts, q):
        placed = base.place(f, q)
        total = 0.0
        for name, body in f['bodies'].items():
            r, x = placed[name]
            total -= body['mass'] * dot(base.GRAVITY, add(x, times(r, body['com'])))
        for name, m in f['muscles'].items():
            stretch = base.length(f, placed, m['path']) - m['line'] + m['radius'] * shafts[name] - m['rest']
            wound = hidden['aim'][name] - hidden['before'][name]
            lost = hidden.get('loss', {}).get(name, 0.0) * (0 if abs(wound) < 0.01 else math.copysign(1.0, wound))
            total += 0.5 * (1.0 - lost) * m['stiffness'] * max(0.0, stretch) ** 2
        for name, t in f['tendons'].items():
            if name in hidden.get('ball', {}):
                body, centre, radius = hidden['ball'][name]
                ends = [add(placed[s[1]][1], times(placed[s[1]][0], s[2])) for s in t['path'] if s[0] == 'at']
                length = over_ball(add(placed[body][1], times(placed[body][0], centre)), radius, *ends)
            else:
                length = base.length(f, placed, t['path'])
            stretch = length - t['p']['rest_length_m']
            total += 0.5 * t['p']['stiffness_N_m'] * max(0.0, stretch) ** 2
        return total
    return energy


def record(f, hidden, dice, file):
    joints = [b['joint'] for b in f['bodies'].values() if b['parent']]
    names = list(f['muscles'])
    limits = [b['limits'] for b in f['bodies'].values() if b['parent']]
    before = {name: 0.0 for name in names}
    base.energy = energy_with(hidden)
    with open(file, 'w') as out:
        out.write('pose,time_s,' + ','.join(f'shaft_{m}_rad' for m in names) + ',' +
                  ','.join(f'{j}_rad' for j in joints) + '\n')
        count = 0
        while count < POSES:
            shafts = {name: round(dice.uniform(*base.RANGES[name]), 6) for name in names}
            hidden.update(aim=shafts, before=before)
            q = base.rest(f, {name: 0.0 for name in names}, [0.0, 0.3, 0.4, 0.25])
            for k in range(1, 5):
                q = base.rest(f, {name: shaft * k / 4 for name, shaft in shafts.items()}, q)
            if sum(min(x - lo, hi - x) < 1e-6 for x, (lo, hi) in zip(q, limits)) > 1:
                continue
            measured = [x + dice.gauss(0, base.NOISE) for x in q]
            out.write(f'p{count:03d},{SECONDS_APART * count:g},' + ','.join(f'{shafts[m]:.9g}' for m in names) + ',' +
                      ','.join(f'{x:.9g}' for x in measured) + '\n')
            before = shafts
            count += 1


def straight(f):
    """The same without the roll below the band of the last joint."""
    band = f['tendons']['dip_band']
    band['path'] = [s for s in band['path'] if s[0] == 'at']
    return f


def main():
    folder = sys.argv[1]
    truth = base.other(base.finger(), random.Random(20))
    record(truth, {}, random.Random(31), f'{folder}/hidden_none.csv')
    record(truth, {'loss': {'extensor': 0.25}}, random.Random(32), f'{folder}/hidden_pulley.csv')
    longer = base.other(base.finger(), random.Random(20))
    longer['tendons']['collateral']['p']['rest_length_m'] += 0.005
    record(longer, {}, random.Random(33), f'{folder}/hidden_ligament.csv')
    banded = straight(base.other(base.finger(), random.Random(20)))
    record(banded, {'ball': {'dip_band': ('middle', [0.032, 0, 0], 0.0085)}}, random.Random(34),
           f'{folder}/hidden_wrap.csv')
    open(f'{folder}/straight_band.yaml', 'w').write(base.yaml(straight(base.finger())))


if __name__ == '__main__':
    main()
