#!/usr/bin/env python3
"""Writes the sample finger: four hinges, four motors, three lines without any, routed over cylinders and a pulley.

    python3 tests/bench/make_finger_data.py data/finger tests/reality/finger

The first folder gets the arm as its drawings have it and poses of another one, whose numbers differ and whose joints
are measured with noise; the second one that other arm itself and noise-free rests. Statics by an independent minimiser:
energies, kinematics and the ways over cylinders are written here anew, derivatives are differences.
"""
import copy
import math
import random
import sys

GRAVITY = (0.0, 0.0, -9.81)
RANGES = {'flexor_profundus': (0.0, 2.8), 'flexor_superficialis': (-0.5, 2.0), 'extensor': (-1.0, 1.0),
          'interosseus': (-0.6, 0.8)}  # [rad] of the shafts
NOISE = math.radians(0.15)  # of a joint's angle


# Vectors and rotations -------------------------------------------------------------------------------------------
def add(a, b):
    return [x + y for x, y in zip(a, b)]


def sub(a, b):
    return [x - y for x, y in zip(a, b)]


def dot(a, b):
    return sum(x * y for x, y in zip(a, b))


def norm(a):
    return math.sqrt(dot(a, a))


def times(m, v):
    return [dot(row, v) for row in m]


def product(a, b):
    return [[sum(a[i][k] * b[k][j] for k in range(3)) for j in range(3)] for i in range(3)]


def turn(axis, angle):
    x, y, z = axis
    c, s = math.cos(angle), math.sin(angle)
    return [[c + x * x * (1 - c), x * y * (1 - c) - z * s, x * z * (1 - c) + y * s],
            [y * x * (1 - c) + z * s, c + y * y * (1 - c), y * z * (1 - c) - x * s],
            [z * x * (1 - c) - y * s, z * y * (1 - c) + x * s, c + z * z * (1 - c)]]


# The finger ------------------------------------------------------------------------------------------------------
def finger():
    """Along x, palm down; flexion turns about y. A path is a list of ('at', body, point), ('over', body, surface,
    side) and ('pulley', divisor)."""
    bodies = {
        'palm': dict(parent=None, mass=0.0, com=[0, 0, 0], radius=0.012, length=0.05,
                     surfaces={'knuckle_roll': dict(radius=0.009, at=[0.0, 0.0, 0.0])}),
        'knuckle': dict(parent='palm', joint='abduction', axis=[0, 0, 1], pivot=[0, 0, 0], limits=(-0.5, 0.5),
                        mass=0.012, com=[0.004, 0, 0], radius=0.008, length=0.01, surfaces={}),
        'proximal': dict(parent='knuckle', joint='mcp', axis=[0, 1, 0], pivot=[0, 0, 0], limits=(-0.4, 1.6), mass=0.055,
                         com=[0.025, 0, 0], radius=0.008, length=0.045,
                         surfaces={'pip_roll': dict(radius=0.0065, at=[0.05, 0.0, 0.0])}),
        'middle': dict(parent='proximal', joint='pip', axis=[0, 1, 0], pivot=[0.05, 0, 0], limits=(-0.1, 1.9),
                       mass=0.035, com=[0.016, 0, 0], radius=0.007, length=0.028,
                       surfaces={'dip_roll': dict(radius=0.005, at=[0.032, 0.0, 0.0])}),
        'distal': dict(parent='middle', joint='dip', axis=[0, 1, 0], pivot=[0.032, 0, 0], limits=(-0.1, 1.4), mass=0.022,
                       com=[0.011, 0, 0], radius=0.006, length=0.02, surfaces={}),
    }
    low, high = [0, 0, -0.03], [0, 0, 0.03]
    flexor = [('at', 'palm', [-0.03, 0.0, -0.012]), ('at', 'palm', [0.001, 0.0, -0.0125]), ('over', 'palm', 'knuckle_roll', low),
              ('at', 'proximal', [0.02, 0.001, -0.011]), ('at', 'proximal', [0.036, 0.0, -0.0105]),
              ('over', 'proximal', 'pip_roll', [0.05, 0, -0.03])]
    muscles = {
        'flexor_profundus': dict(path=flexor + [('at', 'middle', [0.012, 0.0, -0.009]),
                                                ('at', 'middle', [0.022, 0.0, -0.0085]),
                                                ('over', 'middle', 'dip_roll', [0.032, 0, -0.03]),
                                                ('at', 'distal', [0.009, 0.0, -0.0075])], stiffness=1400.0),
        'flexor_superficialis': dict(path=[(*s[:2], add(s[2], [0, 0.002, 0])) if s[0] == 'at' else s for s in flexor] +
                                     [('at', 'middle', [0.01, 0.003, -0.0095])], stiffness=1200.0),
        'extensor': dict(path=[('at', 'palm', [-0.03, 0.0, 0.013]), ('at', 'palm', [0.001, 0.0, 0.0125]),
                               ('over', 'palm', 'knuckle_roll', high),
                               ('at', 'proximal', [0.018, 0.0, 0.012]), ('at', 'proximal', [0.03, 0.0, 0.0115]),
                               ('pulley', 2.0), ('at', 'proximal', [0.03, 0.0, 0.0115]),
                               ('over', 'proximal', 'pip_roll', [0.05, 0, 0.03]), ('at', 'middle', [0.009, 0.0, 0.0085]),
                               ('pulley', 2.0), ('at', 'proximal', [0.03, 0.002, 0.0115]),
                               ('over', 'proximal', 'pip_roll', [0.05, 0, 0.03]), ('at', 'middle', [0.014, 0.002, 0.009]),
                               ('over', 'middle', 'dip_roll', [0.032, 0, 0.03]), ('at', 'distal', [0.007, 0.0, 0.007])],
                         stiffness=1500.0),
        'interosseus': dict(path=[('at', 'palm', [-0.025, 0.016, -0.002]), ('at', 'proximal', [0.014, 0.009, -0.002])],
                            stiffness=900.0),
    }
    for muscle in muscles.values():
        muscle.update(line=0.0, rest=0.06, radius=0.005, damping=8.0)
    tendons = {
        'collateral': dict(kind='ligament', path=[('at', 'palm', [-0.02, -0.014, 0.0]), ('at', 'proximal',
                           [0.012, -0.009, 0.0])], p=dict(rest_length_m=0.0, stiffness_N_m=700.0, damping_Ns_m=2.0)),
        'pip_band': dict(kind='ligament', path=[('at', 'proximal', [0.04, 0.0, 0.011]), ('over', 'proximal', 'pip_roll',
                         [0.05, 0, 0.03]), ('at', 'middle', [0.011, 0.0, 0.0095])],
                         p=dict(rest_length_m=0.0, stiffness_N_m=250.0, damping_Ns_m=1.0)),
        'dip_band': dict(kind='ligament', path=[('at', 'middle', [0.022, 0.0, 0.009]), ('over', 'middle', 'dip_roll',
                         [0.032, 0, 0.03]), ('at', 'distal', [0.01, 0.0, 0.008])],
                         p=dict(rest_length_m=0.0, stiffness_N_m=220.0, damping_Ns_m=1.0)),
    }
    f = dict(bodies=bodies, muscles=muscles, tendons=tendons)
    placed = place(f, [0.0, 0.3, 0.4, 0.25])
    for muscle in muscles.values():  # all just taut in a relaxed posture, shafts at 0
        muscle['line'] = round(length(f, placed, muscle['path']) - muscle['rest'] - 0.004, 5)
    for tendon in tendons.values():
        tendon['p']['rest_length_m'] = round(length(f, placed, tendon['path']) - 0.002, 5)
    return f


# Statics ---------------------------------------------------------------------------------------------------------
def place(f, q):
    """Rotation and origin of every body."""
    identity = [[1, 0, 0], [0, 1, 0], [0, 0, 1]]
    placed = {'palm': (identity, [0.0, 0.0, 0.0])}
    for angle, (name, body) in zip(q, [b for b in f['bodies'].items() if b[1]['parent']]):
        r, x = placed[body['parent']]
        placed[name] = (product(r, turn(body['axis'], angle)), add(x, times(r, body['pivot'])))
    return placed


def over_cylinder(frame, surface, side, a, b):
    """Length of the way from a to b on the side of a cylinder along the body's y where `side` is."""
    r, x = frame
    local = [[dot([r[i][k] for i in range(3)], sub(p, x)) for k in range(3)] for p in (a, b)]
    flat = [(p[0] - surface['at'][0], p[2] - surface['at'][2]) for p in local]
    s = (side[0] - surface['at'][0], side[2] - surface['at'][2])
    height = local[1][1] - local[0][1]
    radius = surface['radius']
    straight = math.dist(*flat)
    da, db = (math.hypot(*p) for p in flat)
    # The nearest point of the straight way, and whether it is on the right side of the cylinder, outside.
    way = (flat[1][0] - flat[0][0], flat[1][1] - flat[0][1])
    share = min(1.0, max(0.0, -(flat[0][0] * way[0] + flat[0][1] * way[1]) / straight ** 2))
    near = (flat[0][0] + share * way[0], flat[0][1] + share * way[1])
    if math.hypot(*near) >= radius and near[0] * s[0] + near[1] * s[1] >= 0.0:
        return math.hypot(straight, height)
    # Angle from a to b through the side.
    angles = [math.atan2(p[1], p[0]) for p in (flat[0], s, flat[1])]
    forward = (angles[2] - angles[0]) % (2 * math.pi)
    passes = (angles[1] - angles[0]) % (2 * math.pi) < forward
    sweep = forward if passes else 2 * math.pi - forward
    arc = sweep - math.acos(radius / da) - math.acos(radius / db)
    return math.hypot(math.sqrt(da ** 2 - radius ** 2) + math.sqrt(db ** 2 - radius ** 2) + radius * arc, height)


def length(f, placed, path):
    total, weight, before, over = 0.0, 1.0, None, None
    for station in path:
        if station[0] == 'pulley':
            weight, before = 1.0 / station[1], None
        elif station[0] == 'over':
            over = station
        else:
            r, x = placed[station[1]]
            now = add(x, times(r, station[2]))
            if before is not None and over is not None:
                surface = f['bodies'][over[1]]['surfaces'][over[2]]
                total += weight * over_cylinder(placed[over[1]], surface, over[3], before, now)
            elif before is not None:
                total += weight * norm(sub(now, before))
            before, over = now, None
    return total


def energy(f, shafts, q):
    placed = place(f, q)
    sum_ = 0.0
    for name, body in f['bodies'].items():
        r, x = placed[name]
        sum_ -= body['mass'] * dot(GRAVITY, add(x, times(r, body['com'])))
    for name, muscle in f['muscles'].items():
        stretch = length(f, placed, muscle['path']) - muscle['line'] + muscle['radius'] * shafts[name] - muscle['rest']
        sum_ += 0.5 * muscle['stiffness'] * max(0.0, stretch) ** 2
    for tendon in f['tendons'].values():
        stretch = length(f, placed, tendon['path']) - tendon['p']['rest_length_m']
        sum_ += 0.5 * tendon['p']['stiffness_N_m'] * max(0.0, stretch) ** 2
    return sum_


def solve(matrix, right):
    n = len(right)
    m = [row[:] + [r] for row, r in zip(matrix, right)]
    for i in range(n):
        p = max(range(i, n), key=lambda k: abs(m[k][i]))
        m[i], m[p] = m[p], m[i]
        for k in range(i + 1, n):
            factor = m[k][i] / m[i][i]
            m[k] = [a - factor * b for a, b in zip(m[k], m[i])]
    for i in reversed(range(n)):
        m[i][n] = (m[i][n] - sum(m[i][k] * m[k][n] for k in range(i + 1, n))) / m[i][i]
    return [row[n] for row in m]


def rest(f, shafts, q):
    """Minimum near q within the limits: Newton on differences of the energy, damped until it goes down."""
    limits = [b['limits'] for b in f['bodies'].values() if b['parent']]
    n = len(q)
    e = lambda p: energy(f, shafts, p)
    moved = lambda p, *steps: [x + sum(s for k, s in steps if k == i) for i, x in enumerate(p)]
    value, damping, h = e(q), 1e-3, 2e-4
    for _ in range(200):
        up, down = ([e(moved(q, (i, s))) for i in range(n)] for s in (h, -h))
        gradient = [(a - b) / (2 * h) for a, b in zip(up, down)]
        hessian = [[0.0] * n for _ in range(n)]
        for i in range(n):
            hessian[i][i] = (up[i] - 2 * value + down[i]) / h ** 2
            for j in range(i):
                cross = (e(moved(q, (i, h), (j, h))) - e(moved(q, (i, h), (j, -h))) - e(moved(q, (i, -h), (j, h))) +
                         e(moved(q, (i, -h), (j, -h)))) / (4 * h * h)
                hessian[i][j] = hessian[j][i] = cross
        held = [(q[i] <= limits[i][0] + 1e-9 and gradient[i] > 0) or (q[i] >= limits[i][1] - 1e-9 and gradient[i] < 0)
                for i in range(n)]
        while True:
            m = [[(1.0 if i == j else 0.0) if held[i] or held[j] else hessian[i][j] + (damping if i == j else 0.0)
                  for j in range(n)] for i in range(n)]
            step = solve(m, [0.0 if held[i] else -gradient[i] for i in range(n)])
            longest = max(abs(s) for s in step)
            if longest > 0.3:
                step = [s * 0.3 / longest for s in step]
            trial = [min(max(x + s, lo), hi) for x, s, (lo, hi) in zip(q, step, limits)]
            trial_value = e(trial)
            if trial_value <= value + 1e-14 or damping > 1e6:
                break
            damping *= 10.0
        way = max(abs(a - b) for a, b in zip(trial, q))
        q, value, damping = trial, trial_value, max(1e-9, damping * 0.1)
        if way < 1e-8:
            break
    return q


# Drawing ---------------------------------------------------------------------------------------------------------
def other(f, dice):
    """A finger as it was built: numbers beside those of the drawing."""
    g = copy.deepcopy(f)
    shift = lambda p, sd: [x + dice.gauss(0, sd) for x in p]
    for line in [*g['muscles'].values(), *g['tendons'].values()]:
        line['path'] = [('at', s[1], shift(s[2], 4e-4)) if s[0] == 'at' else s for s in line['path']]
    for muscle in g['muscles'].values():
        muscle['line'] += dice.gauss(0, 1.5e-3)
        muscle['stiffness'] *= math.exp(dice.gauss(0, 0.08))
        muscle['radius'] *= math.exp(dice.gauss(0, 0.03))
    for tendon in g['tendons'].values():
        tendon['p']['rest_length_m'] += dice.gauss(0, 8e-4)
        tendon['p']['stiffness_N_m'] *= math.exp(dice.gauss(0, 0.15))
    for body in g['bodies'].values():
        for surface in body['surfaces'].values():
            surface['radius'] += dice.gauss(0, 3e-4)
    return g


def poses(f, count, dice):
    drawn = []
    names = list(f['muscles'])
    limits = [b['limits'] for b in f['bodies'].values() if b['parent']]
    while len(drawn) < count:
        shafts = {name: round(dice.uniform(*range_), 6) for name, range_ in RANGES.items()}
        q = rest(f, {name: 0.0 for name in names}, [0.0, 0.3, 0.4, 0.25])
        for k in range(1, 9):  # the way that a slow movement of the shafts takes
            q = rest(f, {name: shaft * k / 8 for name, shaft in shafts.items()}, q)
        at_stop = sum(min(x - lo, hi - x) < 1e-6 for x, (lo, hi) in zip(q, limits))
        if at_stop <= 1:
            drawn.append((shafts, q))
    return drawn


def write_poses(file, f, drawn, dice, noise):
    joints = [b['joint'] for b in f['bodies'].values() if b['parent']]
    with open(file, 'w') as out:
        out.write('pose,' + ','.join(f'shaft_{m}_rad' for m in f['muscles']) + ',' +
                  ','.join(f'{j}_rad' for j in joints) + '\n')
        for k, (shafts, q) in enumerate(drawn):
            measured = [x + dice.gauss(0, noise) if noise else x for x in q]
            out.write(f'p{k:03d},' + ','.join(f'{shafts[m]:.9g}' for m in f['muscles']) + ',' +
                      ','.join(f'{x:.9g}' for x in measured) + '\n')


# The file --------------------------------------------------------------------------------------------------------
def vector(v):
    return '[' + ', '.join(f'{x:.9g}' for x in v) + ']'


def attachments(path):
    texts = []
    for s in path:
        if s[0] == 'at':
            texts.append(f'{{body: {s[1]}, point_m: {vector(s[2])}}}')
        elif s[0] == 'over':
            texts.append(f'{{over: {s[2]}, body: {s[1]}, side_m: {vector(s[3])}}}')
        else:
            texts.append(f'{{pulley: {s[1]:g}}}')
    return '    attachments:\n' + ''.join(f'      - {t}\n' for t in texts)


def yaml(f):
    text = 'format: simgap/arm/2\nname: finger\ngravity_m_s2: [0, 0, -9.81]\nbodies:\n'
    for name, b in f['bodies'].items():
        text += f'  - name: {name}\n'
        if b['parent'] is None:
            text += '    fixed: true\n'
        else:
            text += (f'    parts:\n      - {{name: bone, shape: capsule, radius_m: {b["radius"]}, length_m: {b["length"]}, '
                     f'mass_kg: {b["mass"]}, position_m: {vector(b["com"])}, axis: [1, 0, 0]}}\n')
        if b['surfaces']:
            text += '    surfaces:\n'
        for surface, s in b['surfaces'].items():
            text += (f'      - {{name: {surface}, shape: cylinder, radius_m: {s["radius"]:.9g}, position_m: '
                     f'{vector(s["at"])}, axis: [0, 1, 0]}}\n')
    text += 'joints:\n'
    for name, b in f['bodies'].items():
        if b['parent'] is not None:
            text += (f'  - {{name: {b["joint"]}, type: revolute, parent: {b["parent"]}, child: {name}, parent_position_m: '
                     f'{vector(b["pivot"])}, child_position_m: [0, 0, 0], axis: {vector(b["axis"])}, lower_limit_rad: '
                     f'{b["limits"][0]}, upper_limit_rad: {b["limits"][1]}, coulomb_friction_Nm: 0.0005, '
                     'viscous_friction_Nms: 0.002}\n')
    text += ('motor_defaults: {resistance_ohm: 8.0, inductance_H: 0.0002, back_emf_constant_Vs: 0.0045, '
             'torque_constant_Nm_A: 0.0045, inertia_kg_m2: 1.0e-7, viscous_friction_Nms: 1.0e-7, '
             'coulomb_friction_Nm: 0.0002, supply_voltage_V: 12}\n'
             'gearbox_defaults: {ratio: 100, efficiency: 0.7, inertia_kg_m2: 1.0e-6, viscous_friction_Nms: 0.0005, '
             'coulomb_friction_Nm: 0.005}\nmuscles:\n')
    for name, m in f['muscles'].items():
        text += f'  - name: {name}\n' + attachments(m['path'])
        text += (f'    kite_line_length_m: {m["line"]:.9g}\n    shock_cord: {{rest_length_m: {m["rest"]}, stiffness_N_m: '
                 f'{m["stiffness"]:.9g}, damping_Ns_m: {m["damping"]}}}\n    spindle_radius_m: {m["radius"]:.9g}\n')
    text += 'tendons:\n'
    for name, t in f['tendons'].items():
        text += f'  - name: {name}\n    kind: {t["kind"]}\n' + attachments(t['path'])
        text += ''.join(f'    {key}: {value:.9g}\n' for key, value in t['p'].items())
    return text


def main():
    data, truth_folder = sys.argv[1:]
    dice = random.Random(20)
    drawing = finger()
    truth = other(drawing, dice)
    open(f'{data}/arm.yaml', 'w').write(yaml(drawing))
    open(f'{truth_folder}/arm.yaml', 'w').write(yaml(truth))
    calibration, validation = poses(truth, 40, dice), poses(truth, 20, dice)
    write_poses(f'{data}/poses_calibration.csv', truth, calibration, dice, NOISE)
    write_poses(f'{data}/poses_validation.csv', truth, validation, dice, NOISE)
    write_poses(f'{truth_folder}/rests.csv', truth, calibration, dice, 0.0)


if __name__ == '__main__':
    main()
