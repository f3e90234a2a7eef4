#!/usr/bin/env python3
"""Writes the sample arm without spindles: a motor turns its shoulder, two pneumatic muscles its elbow, a servo its wrist.

    python3 tests/bench/make_pneumatic_data.py data/pneumatic tests/reality/pneumatic

The first folder gets the arm as its drawings have it and poses of another one, whose numbers differ and whose joints are
measured with noise; the second one that other arm itself and noise-free rests. Statics written anew: torques by
differences of lengths, the muscles' force by bisection of 002 eq. 16, rests by Newton's method on the torques while the
commands grow from 0.
"""
import copy
import math
import os
import random
import sys

NOISE = math.radians(0.15)
G = 9.81


def arm():
    """Hinges about x in the plane (y, z); every body hangs along -z of its frame when its joint is at 0."""
    return {
        'lengths': [0.28, 0.25],
        'masses': [(1.1, 0.13), (0.6, 0.11), (0.2, 0.05)],  # kg, m below the joint
        'motor': dict(torque_constant=0.03, ratio=60.0, efficiency=0.7),
        'servo': dict(stiffness=1.5, offset=0.0),
        'biceps': dict(upper=(0.03, -0.05), lower=(0.03, -0.04), a=8e-3, b=-6e-3, c=1e-3, k=4000.0, length=0.2, rest=0.235),
        'triceps': dict(upper=(-0.03, -0.05), lower=(-0.03, 0.02), a=8e-3, b=-6e-3, c=1e-3, k=4000.0, length=0.2,
                        rest=0.255),
    }


def turned(point, angle):
    y, z = point
    return (y * math.cos(angle) - z * math.sin(angle), y * math.sin(angle) + z * math.cos(angle))


def muscle_length(muscle, model, elbow):
    y, z = turned(muscle['lower'], elbow)
    return math.hypot(y - muscle['upper'][0], z - model['lengths'][0] - muscle['upper'][1])


def muscle_force(m, pressure, length):
    """The force that solves f = p g(eps + f/k) on the branch where g falls, by bisection."""
    eps = (m['rest'] - length) / m['length']
    lowest = -m['b'] / (2 * m['a'])

    def excess(f):
        x = min(eps + f / m['k'], lowest)
        return pressure * (m['a'] * x * x + m['b'] * x + m['c']) - f

    if pressure <= 0 or excess(0.0) <= 0:
        return 0.0
    low, high = 0.0, 1.0
    while excess(high) > 0:
        high *= 2
    for _ in range(200):
        middle = 0.5 * (low + high)
        low, high = (middle, high) if excess(middle) > 0 else (low, middle)
    return 0.5 * (low + high)


def torques(model, q, command):
    """What turns each joint towards larger angles; 0 at rest."""
    shoulder, elbow, wrist = q
    ends = [shoulder, shoulder + elbow, shoulder + elbow + wrist]
    total = [0.0, 0.0, 0.0]
    for b, (mass, below) in enumerate(model['masses']):  # centre: sum of bones above and its own part
        for j in range(b + 1):
            arm_y = sum(model['lengths'][i] * math.sin(ends[i]) for i in range(j, b)) + below * math.sin(ends[b])
            total[j] -= mass * G * arm_y
    m = model['motor']
    total[0] += m['torque_constant'] * m['ratio'] * m['efficiency'] * command['current_shoulder']
    s = model['servo']
    total[2] += s['stiffness'] * (command['target_wrist'] + s['offset'] - wrist)
    for name in ('biceps', 'triceps'):
        h = 1e-6
        ahead, behind = (muscle_length(model[name], model, elbow + d) for d in (h, -h))
        force = muscle_force(model[name], command['pressure_' + name], muscle_length(model[name], model, elbow))
        total[1] -= force * (ahead - behind) / (2 * h)
    return total


def solve3(a, b):
    rows = [row[:] + [value] for row, value in zip(a, b)]
    for i in range(3):
        p = max(range(i, 3), key=lambda r: abs(rows[r][i]))
        rows[i], rows[p] = rows[p], rows[i]
        for r in range(3):
            if r != i:
                f = rows[r][i] / rows[i][i]
                rows[r] = [x - f * y for x, y in zip(rows[r], rows[i])]
    return [rows[i][3] / rows[i][i] for i in range(3)]


def rest(model, command):
    q = [0.0, 0.05, 0.0]
    steps = 40
    for k in range(1, steps + 1):
        part = {name: value * k / steps for name, value in command.items()}
        for _ in range(60):
            now = torques(model, q, part)
            h = 1e-5
            jacobian = [[0.0] * 3 for _ in range(3)]
            for j in range(3):
                ahead, behind = q[:], q[:]
                ahead[j] += h
                behind[j] -= h
                up, down = torques(model, ahead, part), torques(model, behind, part)
                for i in range(3):
                    jacobian[i][j] = (up[i] - down[i]) / (2 * h)
            way = solve3(jacobian, [-x for x in now])
            longest = max(abs(x) for x in way)
            q = [x + dx * min(1.0, 0.2 / max(longest, 1e-300)) for x, dx in zip(q, way)]
            if longest < 1e-9:
                break
        else:
            return None
    return q


def other(model, rng):
    """Another specimen: what drawings and data sheets do not know."""
    true = copy.deepcopy(model)
    true['motor']['torque_constant'] *= 1.06
    true['motor']['efficiency'] *= 0.93
    true['servo']['stiffness'] *= 1.08
    true['servo']['offset'] = 0.03
    for name in ('biceps', 'triceps'):
        m = true[name]
        for key, sd in (('a', 0.05), ('b', 0.04), ('c', 0.04), ('k', 0.05)):
            m[key] *= 1 + sd * rng.gauss(0, 1)
        m['rest'] += 0.003 * rng.gauss(0, 1)
        for key in ('upper', 'lower'):
            m[key] = tuple(x + 0.001 * rng.gauss(0, 1) for x in m[key])
    return true


def yaml(model, name):
    def muscle(n):
        m = model[n]
        return f"""  - name: {n}
    kind: pneumatic-muscle
    attachments: [{{body: upper, point_m: [0, {m['upper'][0]!r}, {m['upper'][1]!r}]}}, {{body: lower, point_m: [0, {m['lower'][0]!r}, {m['lower'][1]!r}]}}]
    a_m2: {m['a']!r}
    b_m2: {m['b']!r}
    c_m2: {m['c']!r}
    k_N: {m['k']!r}
    muscle_length_m: {m['length']!r}
    rest_length_m: {m['rest']!r}
    damping_Ns_m: 60
"""
    bodies = ''
    for body, (mass, below), length in zip(('upper', 'lower', 'hand'), model['masses'], model['lengths'] + [0.1]):
        bodies += f"""  - name: {body}
    parts:
      - {{name: bone, shape: cylinder, radius_m: 0.02, length_m: {length}, axis: [0, 0, 1], mass_kg: {mass}, position_m: [0, 0, {-below}]}}
"""
    m, s = model['motor'], model['servo']
    return f"""# {name}. Written by tests/bench/make_pneumatic_data.py.
format: simgap/arm/2
name: {name}
gravity_m_s2: [0, 0, {-G}]
bodies:
  - name: base
    fixed: true
{bodies}joints:
  - {{name: shoulder, type: revolute, parent: base, child: upper, parent_position_m: [0, 0, 0], child_position_m: [0, 0, 0], axis: [1, 0, 0], lower_limit_rad: -1.5, upper_limit_rad: 1.5, coulomb_friction_Nm: 0.001, viscous_friction_Nms: 0.3}}
  - {{name: elbow, type: revolute, parent: upper, child: lower, parent_position_m: [0, 0, {-model['lengths'][0]}], child_position_m: [0, 0, 0], axis: [1, 0, 0], lower_limit_rad: -0.9, upper_limit_rad: 2.4, coulomb_friction_Nm: 0.001, viscous_friction_Nms: 0.15}}
  - {{name: wrist, type: revolute, parent: lower, child: hand, parent_position_m: [0, 0, {-model['lengths'][1]}], child_position_m: [0, 0, 0], axis: [1, 0, 0], lower_limit_rad: -1.2, upper_limit_rad: 1.2, coulomb_friction_Nm: 0.001, viscous_friction_Nms: 0.05}}
muscles: []
tendons:
  - {{name: shoulder, kind: joint-motor, joint: shoulder, torque_constant_Nm_A: {m['torque_constant']!r}, ratio: {m['ratio']!r}, efficiency: {m['efficiency']!r}, viscous_friction_Nms: 0.05}}
{muscle('biceps')}{muscle('triceps')}  - {{name: wrist, kind: joint-servo, joint: wrist, stiffness_Nm_rad: {s['stiffness']!r}, offset_rad: {s['offset']!r}, damping_Nms: 0.05}}
"""


def draw(model, rng):
    while True:
        command = {'current_shoulder': round(rng.uniform(-2.2, 2.2), 3),
                   'pressure_biceps': round(rng.uniform(0.3e5, 3.5e5), -2),
                   'pressure_triceps': round(rng.uniform(0.3e5, 3.5e5), -2),
                   'target_wrist': round(rng.uniform(-0.9, 0.9), 3)}
        q = rest(model, command)
        if q and abs(q[0]) < 1.4 and -0.85 < q[1] < 2.3 and abs(q[2]) < 1.15:
            return command, q


def write(path, poses, rng, noise):
    with open(path, 'w') as out:
        out.write('pose,current_shoulder_A,pressure_biceps_bar,pressure_triceps_bar,target_wrist_rad,shoulder_rad,'
                  'elbow_rad,wrist_rad\n')
        for i, (c, q) in enumerate(poses):
            seen = [x + noise * rng.gauss(0, 1) for x in q]
            out.write(f"p{i + 1:02d},{c['current_shoulder']},{c['pressure_biceps'] / 1e5},{c['pressure_triceps'] / 1e5},"
                      f"{c['target_wrist']},{seen[0]:.9f},{seen[1]:.9f},{seen[2]:.9f}\n")


def main():
    sample, reality = sys.argv[1:3]
    for folder in (sample, reality):
        os.makedirs(folder, exist_ok=True)
    rng = random.Random(19)
    nominal = arm()
    true = other(nominal, rng)
    with open(os.path.join(sample, 'arm.yaml'), 'w') as out:
        out.write(yaml(nominal, 'pneumatic-arm'))
    with open(os.path.join(reality, 'arm.yaml'), 'w') as out:
        out.write(yaml(true, 'another-pneumatic-arm'))
    poses = [draw(true, rng) for _ in range(60)]
    write(os.path.join(sample, 'poses_calibration.csv'), poses[:30], rng, NOISE)
    write(os.path.join(sample, 'poses_validation.csv'), poses[30:50], rng, NOISE)
    write(os.path.join(reality, 'rests.csv'), poses[30:], rng, 0.0)


main()
