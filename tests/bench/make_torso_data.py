#!/usr/bin/env python3
"""Writes the sample torso: two arms of eleven muscles each, on one fixed body, and poses in which one or both are moved.

    python3 tests/bench/make_torso_data.py data/torso

The drawing is the sample arm (data/arm/arm.yaml), to the right, and its mirror image, to the left. The torso that was
recorded is another one: attachments, lengths, stiffnesses and radii differ from the drawing as hands measure, joints
stop where their friction holds them, and each is measured with 0.3 deg of noise per component. Statics by an
independent minimiser: energy and kinematics are written here anew, derivatives are differences.

Files: arm.yaml; poses_right.csv and poses_left.csv (only that arm's shafts are moved, the other arm hangs),
poses_both.csv and poses_validation.csv (both), poses_all.csv (the first three in one file, under names of their own).
"""
import copy
import math
import random
import sys

from make_finger_data import add, dot, norm, product, solve, sub, times, turn, vector

GRAVITY = (0.0, 0.0, -9.81)
NOISE = math.radians(0.3)   # per component of a joint
LONGEST_SHAFT = 7.0         # [rad]
LINEAR = 0.75               # of a cord's rest length
SHOULDER = (0.17, 0.0, 0.1)  # [m] of the right one
MUSCLES = {  # body and point of both ends, kite line, stiffness: data/arm/arm.yaml
    'deltoid_anterior': (('torso', (0.01, 0.072, 0.055)), ('humerus', (0.004, 0.024, -0.112)), 0.0839, 900),
    'deltoid_lateral': (('torso', (0.074, 0.004, 0.066)), ('humerus', (0.025, 0.002, -0.121)), 0.1033, 900),
    'deltoid_posterior': (('torso', (0.006, -0.079, 0.05)), ('humerus', (0.003, -0.026, -0.108)), 0.0767, 900),
    'pectoralis_major': (('torso', (-0.142, 0.084, -0.058)), ('humerus', (-0.012, 0.021, -0.082)), 0.0564, 800),
    'latissimus_dorsi': (('torso', (-0.121, -0.092, -0.196)), ('humerus', (-0.011, -0.022, -0.071)), 0.0906, 800),
    'infraspinatus': (('torso', (-0.102, -0.071, -0.046)), ('humerus', (0.014, -0.021, -0.052)), 0.0365, 850),
    'supraspinatus': (('torso', (-0.083, -0.018, 0.064)), ('humerus', (0.021, 0.003, 0.031)), 0.0211, 850),
    'subscapularis': (('torso', (-0.089, 0.031, -0.022)), ('humerus', (-0.021, 0.018, -0.033)), -0.0199, 850),
    'biceps': (('torso', (-0.012, 0.043, 0.048)), ('forearm', (0.002, 0.026, -0.046)), 0.2846, 950),
    'brachialis': (('humerus', (0.003, 0.021, -0.152)), ('forearm', (0, 0.021, -0.041)), 0.079, 900),
    'triceps': (('humerus', (0, -0.022, -0.121)), ('forearm', (0.001, -0.026, 0.029)), 0.0401, 950),
}
PARTS = {  # name, radius, length, mass, place
    'humerus': (('bone', 0.018, 0.28, 0.31, (0, 0, -0.14)), ('actuators', 0.022, 0.10, 0.74, (0, 0.0056757, -0.1187162))),
    'forearm': (('bone', 0.015, 0.24, 0.18, (0, 0, -0.12)), ('fittings', 0.03, 0.08, 0.44, (0, 0.0042273, -0.1171818))),
}
ELBOW = (0.0, 0.0, -0.28)
ELBOW_LIMITS = (0.0, 2.3562)
FRICTION = {'shoulder': 0.05, 'elbow': 0.02}
IDENTITY = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]]


def arm(side):
    """One arm about its shoulder: 1 the right one, -1 its mirror image."""
    mirrored = lambda p: [side * p[0], p[1], p[2]]
    return {name: dict(ends=[[a[0], mirrored(a[1])], [b[0], mirrored(b[1])]], line=line, rest=0.08, stiffness=float(k),
                       radius=0.006) for name, (a, b, line, k) in MUSCLES.items()}


def built(drawing, dice):
    """An arm as it was built, beside its drawing."""
    a = copy.deepcopy(drawing)
    for m in a.values():
        for end, sd in zip(m['ends'], (7e-3, 3.5e-3)):
            end[1] = [x + dice.gauss(0, sd) for x in end[1]]
        m['line'] += dice.gauss(0, 11e-3)
        m['stiffness'] *= math.exp(dice.gauss(0, 0.13))
        m['radius'] *= math.exp(dice.gauss(0, 0.05))
    return a


# Statics: a position is the shoulder's rotation and the elbow's angle ---------------------------------------------
def exponential(w):
    angle = norm(w)
    return turn([x / angle for x in w], angle) if angle > 1e-12 else IDENTITY


def moved(q, w):
    low, high = ELBOW_LIMITS
    return product(q[0], exponential(w[:3])), min(max(q[1] + w[3], low), high)


def place(q):
    shoulder, angle = q
    return {'torso': (IDENTITY, (0, 0, 0)), 'humerus': (shoulder, (0, 0, 0)),
            'forearm': (product(shoulder, turn((1.0, 0.0, 0.0), angle)), times(shoulder, ELBOW))}


def stretches(a, shafts, q):
    placed = place(q)
    for name, m in a.items():
        x = [add(placed[body][1], times(placed[body][0], point)) for body, point in m['ends']]
        yield m, norm(sub(x[1], x[0])) - m['line'] + m['radius'] * shafts[name] - m['rest']


def energy(a, shafts, q):
    placed = place(q)
    total = 0.0
    for body, parts in PARTS.items():
        for _, _, _, mass, at in parts:
            total -= mass * dot(GRAVITY, add(placed[body][1], times(placed[body][0], at)))
    return total + sum(0.5 * m['stiffness'] * max(0.0, x) ** 2 for m, x in stretches(a, shafts, q))


def derivatives(a, shafts, q, h=2e-4):
    unit = lambda *steps: [sum(s for k, s in steps if k == i) for i in range(4)]
    # The elbow must be free to move both ways for differences: they are taken without its stops.
    e = lambda w: energy(a, shafts, (product(q[0], exponential(w[:3])), q[1] + w[3]))
    value = e(unit())
    up, down = ([e(unit((i, s))) for i in range(4)] for s in (h, -h))
    gradient = [(u - d) / (2 * h) for u, d in zip(up, down)]
    hessian = [[0.0] * 4 for _ in range(4)]
    for i in range(4):
        hessian[i][i] = (up[i] - 2 * value + down[i]) / h ** 2
        for j in range(i):
            cross = (e(unit((i, h), (j, h))) - e(unit((i, h), (j, -h))) - e(unit((i, -h), (j, h))) +
                     e(unit((i, -h), (j, -h)))) / (4 * h * h)
            hessian[i][j] = hessian[j][i] = cross
    return value, gradient, hessian


def held_elbow(q, gradient):
    low, high = ELBOW_LIMITS
    return (q[1] <= low + 1e-9 and gradient[3] > 0) or (q[1] >= high - 1e-9 and gradient[3] < 0)


def newton(hessian, right, held, damping):
    m = [[(1.0 if i == j else 0.0) if held and 3 in (i, j) else hessian[i][j] + (damping if i == j else 0.0)
          for j in range(4)] for i in range(4)]
    return solve(m, [0.0 if held and i == 3 else r for i, r in enumerate(right)])


def rest(a, shafts, q):
    damping = 1e-3
    for _ in range(100):
        value, gradient, hessian = derivatives(a, shafts, q)
        held = held_elbow(q, gradient)
        while True:
            step = newton(hessian, [-g for g in gradient], held, damping)
            longest = max(abs(s) for s in step)
            step = [s * min(1.0, 0.3 / longest) for s in step] if longest > 0 else step
            trial = moved(q, step)
            if energy(a, shafts, trial) <= value + 1e-13 or damping > 1e6:
                break
            damping *= 10.0
        q, damping = trial, max(1e-9, damping * 0.1)
        if max(abs(s) for s in step) < 1e-7:
            return q
    return None


def follow(a, shafts):
    """Where the arm comes to when its shafts are wound slowly from 0; None where it jumps."""
    q = rest(a, {name: 0.0 for name in a}, (IDENTITY, 0.3))
    for k in range(1, 9):
        q = q and rest(a, {name: shaft * k / 8 for name, shaft in shafts.items()}, q)
    return q


def stuck(a, shafts, q, dice):
    """Somewhere within what friction holds, and as a camera sees it."""
    _, gradient, hessian = derivatives(a, shafts, q)
    direction = [dice.gauss(0, 1) for _ in range(3)]
    size = FRICTION['shoulder'] * dice.random() ** (1 / 3) / norm(direction)
    torque = [size * x for x in direction] + [FRICTION['elbow'] * dice.uniform(-1, 1)]
    step = newton(hessian, torque, held_elbow(q, gradient), 0.0)
    if max(abs(s) for s in step) < 0.2:
        q = moved(q, step)
    return product(q[0], exponential([dice.gauss(0, NOISE) for _ in range(3)])), q[1] + dice.gauss(0, NOISE)


def command(a, dice):
    """Shafts that lead to a rest with all cords in their linear range, and that rest."""
    while True:
        shafts = {name: round(dice.uniform(0.0, LONGEST_SHAFT) * dice.choice((0.3, 1.0)), 6) for name in a}
        q = follow(a, shafts)
        if q and all(x < LINEAR * m['rest'] for m, x in stretches(a, shafts, q)):
            return shafts, q


# Files -----------------------------------------------------------------------------------------------------------
def quaternion(r):
    """Of a rotation by less than half a turn or so: the largest component first, then the others."""
    squares = [1 + r[0][0] + r[1][1] + r[2][2], 1 + r[0][0] - r[1][1] - r[2][2], 1 - r[0][0] + r[1][1] - r[2][2],
               1 - r[0][0] - r[1][1] + r[2][2]]
    k = max(range(4), key=lambda i: squares[i])
    s = math.sqrt(squares[k])
    x, y, z = r[2][1] - r[1][2], r[0][2] - r[2][0], r[1][0] - r[0][1]
    xy, xz, yz = r[0][1] + r[1][0], r[0][2] + r[2][0], r[1][2] + r[2][1]
    rows = ([squares[0], x, y, z], [x, squares[1], xy, xz], [y, xy, squares[2], yz], [z, xz, yz, squares[3]])
    return [0.5 * v / s for v in rows[k]]


def columns():
    names = ['pose'] + [f'shaft_{side}_{m}_rad' for side in 'rl' for m in MUSCLES]
    for side in 'rl':
        names += [f'{side}_shoulder_q{c}' for c in 'wxyz'] + [f'{side}_elbow_rad']
    return ','.join(names) + '\n'


def write_poses(file, arms, count, moves, dice):
    with open(file, 'w') as out:
        out.write(columns())
        for k in range(count):
            shafts, joints = [], []
            for side in 'rl':
                a = arms[side]
                s, q = command(a, dice) if side in moves else ({m: 0.0 for m in a}, follow(a, {m: 0.0 for m in a}))
                shoulder, elbow = stuck(a, s, q, dice)
                shafts += [f'{s[m]:.9g}' for m in MUSCLES]
                joints += [f'{c:.9g}' for c in quaternion(shoulder)] + [f'{elbow:.9g}']
            out.write(f'p{k:03d},' + ','.join(shafts + joints) + '\n')


def yaml(arms):
    text = ('format: simgap/arm/1\nname: torso\ngravity_m_s2: [0, 0, -9.81]\nbodies:\n  - {name: torso, fixed: true}\n')
    shoulder = {'r': list(SHOULDER), 'l': [-SHOULDER[0], *SHOULDER[1:]]}
    for side in 'rl':
        for body, parts in PARTS.items():
            text += f'  - name: {side}_{body}\n    parts:\n'
            for name, radius, length, mass, at in parts:
                text += (f'      - {{name: {name}, shape: cylinder, radius_m: {radius}, length_m: {length}, mass_kg: {mass}, '
                         f'position_m: {vector(at)}, axis: [0, 0, 1]}}\n')
    text += 'joints:\n'
    for side in 'rl':
        text += (f'  - {{name: {side}_shoulder, type: spherical, parent: torso, child: {side}_humerus, parent_position_m: '
                 f'{vector(shoulder[side])}, child_position_m: [0, 0, 0], coulomb_friction_Nm: {FRICTION["shoulder"]}, '
                 f'viscous_friction_Nms: 0.05}}\n'
                 f'  - {{name: {side}_elbow, type: revolute, parent: {side}_humerus, child: {side}_forearm, '
                 f'parent_position_m: {vector(ELBOW)}, child_position_m: [0, 0, 0], axis: [1, 0, 0], lower_limit_rad: '
                 f'{ELBOW_LIMITS[0]}, upper_limit_rad: {ELBOW_LIMITS[1]}, coulomb_friction_Nm: {FRICTION["elbow"]}, '
                 f'viscous_friction_Nms: 0.02}}\n')
    text += ('motor_defaults: {resistance_ohm: 0.8, inductance_H: 0.0003, back_emf_constant_Vs: 0.011, '
             'torque_constant_Nm_A: 0.011, inertia_kg_m2: 2.0e-6, viscous_friction_Nms: 1.0e-6, coulomb_friction_Nm: '
             '0.002, supply_voltage_V: 12}\ngearbox_defaults: {ratio: 72, efficiency: 0.72, inertia_kg_m2: 1.0e-5, '
             'viscous_friction_Nms: 0.002, coulomb_friction_Nm: 0.03}\nmuscles:\n')
    for side in 'rl':
        for name, m in arms[side].items():
            ends = []
            for body, point in m['ends']:
                on_torso = body == 'torso'
                at = add(shoulder[side], point) if on_torso else point
                ends.append(f'{{body: {body if on_torso else side + "_" + body}, point_m: {vector(at)}}}')
            text += (f'  - name: {side}_{name}\n    attachments: [{", ".join(ends)}]\n    kite_line_length_m: '
                     f'{m["line"]:.9g}\n    shock_cord: {{rest_length_m: {m["rest"]}, stiffness_N_m: {m["stiffness"]:.9g}, '
                     f'damping_Ns_m: 15}}\n    spindle_radius_m: {m["radius"]:.9g}\n')
    return text


def write_all(data):
    """The steps' poses in one file: r000 of the right arm, l000 of the left, b000 of both."""
    rows = []
    for name in ('right', 'left', 'both'):
        header, *poses = open(f'{data}/poses_{name}.csv').read().splitlines()
        rows += [name[0] + pose[1:] for pose in poses]
    open(f'{data}/poses_all.csv', 'w').write('\n'.join([header] + rows) + '\n')


def main():
    data = sys.argv[1]
    dice = random.Random(22)
    drawing = {'r': arm(1.0), 'l': arm(-1.0)}
    truth = {side: built(drawing[side], dice) for side in 'rl'}
    open(f'{data}/arm.yaml', 'w').write(yaml(drawing))
    write_poses(f'{data}/poses_right.csv', truth, 20, 'r', dice)
    write_poses(f'{data}/poses_left.csv', truth, 20, 'l', dice)
    write_poses(f'{data}/poses_both.csv', truth, 30, 'rl', dice)
    write_poses(f'{data}/poses_validation.csv', truth, 15, 'rl', dice)
    write_all(data)


if __name__ == '__main__':
    main()
