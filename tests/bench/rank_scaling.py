#!/usr/bin/env python3
"""A model of how a generation of `mpirun -n N simgap calibrate` scales, to 1,000 ranks.

    tests/bench/rank_scaling.py

Event by event as src/core/ranks.cpp works: ranks ask for tasks before they run out of them, the first rank answers one
message after the other and works itself, and hands out fewer towards the end; at the end all results go to all ranks.
What the model is given was measured on one machine (docs/studies/cluster.md); the network's figures are assumptions,
printed with the table. Poses differ in length as those of the sample arm do, and some ranks are slow (stragglers).
"""
import heapq
import math
import random

POSE_S = 3.4e-3        # a pose in Bullet, docs/performance.md
POSE_SPREAD = 0.35     # standard deviation of its logarithm
SERIAL_S = 1.2e-3      # per generation on every rank: the strategy, judging, history
STRAGGLER_SHARE = 0.05
STRAGGLER_FACTOR = 1.5
LATENCY_S = 30e-6      # of a message: 1 to 2 us on InfiniBand, 30 us on Ethernet
PAUSE_S = 120e-6       # mean wait of a rank that looks for messages
ANSWER_S = 6e-6        # of the first rank, per message
RESULT_BYTES = 420     # of a pose
BYTES_PER_S = 1.2e9    # 10 Gbit/s


def generation(ranks, threads, tasks, seed):
    """Seconds of one generation. Every thread of every rank is one event queue entry."""
    rng = random.Random(seed)
    slow = [1.0 if r == 0 or rng.random() > STRAGGLER_SHARE else STRAGGLER_FACTOR for r in range(ranks)]
    length = [POSE_S * math.exp(rng.gauss(0.0, POSE_SPREAD) - POSE_SPREAD ** 2 / 2) for _ in range(tasks)]
    given = 0

    def take():
        nonlocal given
        given += 1
        return given - 1

    queue = [[] for _ in range(ranks)]      # tasks a rank holds
    idle = [threads] * ranks
    outstanding = [0] * ranks               # tasks handed to a rank and not finished
    asked = [False] * ranks
    server = 0.0                            # the first rank's messenger is free again
    events, order = [], 0
    finished, end = 0, 0.0

    def push(time, kind, rank):
        nonlocal order
        order += 1
        heapq.heappush(events, (time, order, kind, rank))

    def start(time, rank):
        while idle[rank] > 0:
            if rank == 0:
                if given >= tasks:
                    return
                task = take()
            elif queue[rank]:
                task = queue[rank].pop()
            else:
                return
            idle[rank] -= 1
            push(time + length[task] * slow[rank], 'done', rank)

    depth = math.ceil(math.log2(ranks)) if ranks > 1 else 0
    for rank in range(1, ranks):
        asked[rank] = True
        push(depth * LATENCY_S + LATENCY_S, 'ask', rank)
    start(0.0, 0)
    while finished < tasks:
        time, _, kind, rank = heapq.heappop(events)
        if kind == 'done':
            finished += 1
            idle[rank] += 1
            end = max(end, time + (0.0 if rank == 0 else LATENCY_S + PAUSE_S + ANSWER_S))
            if rank > 0:
                outstanding[rank] -= 1
                if not asked[rank] and given < tasks:
                    asked[rank] = True
                    push(time + LATENCY_S, 'ask', rank)
            start(time, rank)
        elif kind == 'ask':
            server = max(server, time + PAUSE_S * (server < time)) + ANSWER_S
            wanted = 2 * threads - outstanding[rank]
            fair = max(1, (tasks - given) // (2 * ranks))
            for _ in range(min(wanted, fair, tasks - given)):
                outstanding[rank] += 1
                queue[rank].append(take())
            push(server + LATENCY_S + PAUSE_S, 'answer', rank)
        else:
            asked[rank] = False
            start(time, rank)
            if outstanding[rank] < 2 * threads and given < tasks:
                asked[rank] = True
                push(time + LATENCY_S, 'ask', rank)
    end = max(end, server)
    spread = depth * LATENCY_S + (2.0 if ranks > 2 else 1.0) * tasks * RESULT_BYTES / BYTES_PER_S if ranks > 1 else 0.0
    return end + spread + SERIAL_S


def mean(ranks, threads, tasks, runs=5):
    return sum(generation(ranks, threads, tasks, seed) for seed in range(runs)) / runs


def main():
    print(f'assumed: {LATENCY_S * 1e6:.0f} us and {BYTES_PER_S * 8e-9:.1f} Gbit/s a message, '
          f'{100 * STRAGGLER_SHARE:.0f} % of the ranks {STRAGGLER_FACTOR} times as slow\n')
    cases = [('the paper: 36 x 15 poses', 540), ('36 x 100', 3600), ('360 x 100', 36000)]
    alone = {tasks: mean(1, 1, tasks) for _, tasks in cases}
    print('| ranks of 1 thread | ' + ' | '.join(name for name, _ in cases) + ' |')
    print('|---' * (len(cases) + 1) + '|')
    for ranks in (1, 2, 4, 8, 16, 32, 64, 128, 256, 512, 1000):
        cells = []
        for _, tasks in cases:
            seconds = mean(ranks, 1, tasks, 5 if tasks < 10000 else 1)
            speed = alone[tasks] / seconds
            cells.append(f'{1e3 * seconds:.1f} ms, {speed:.1f} x ({100 * speed / ranks:.0f} %)')
        print(f'| {ranks} | ' + ' | '.join(cells) + ' |')
    print('\nThe paper\'s 250 generations (135,000 poses):')
    for ranks, threads in ((1, 1), (1, 2), (2, 1), (64, 1), (8, 8), (4, 16)):
        print(f'  {ranks:3d} ranks x {threads:2d} threads: {250 * mean(ranks, threads, 540):7.1f} s')


if __name__ == '__main__':
    main()
