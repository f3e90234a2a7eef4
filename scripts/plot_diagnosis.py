#!/usr/bin/python3
"""A diagnosis: the gap and its noise floor, the evidence before and after the causes, what each cause saves, and the
self-test's confusion matrix (needs python3-matplotlib).

    scripts/plot_diagnosis.py runs/diagnosis -o diagnosis.pdf
"""
import math

import plotting


def plot_gap(axes, result):
    errors = [result["baseline"]["noise_floor"], result["baseline"]["mse_heldout"], result["extended"]["mse_heldout"]]
    axes.bar(["noise\nfloor", "the model\nas it is", "with the\ncauses"], [math.sqrt(error or 0.0) for error in errors],
             color=[plotting.GREY, plotting.COLOURS[1], plotting.COLOURS[0]])
    axes.set(ylabel=f"RMS error [{result['error_unit'].removesuffix('2')}]", title="on data never used")


def plot_gains(axes, causes):
    for place, cause in enumerate(reversed(causes)):
        low, high = cause["gain_ci95"]
        gain = cause["gain_heldout_percent"]
        axes.errorbar(gain, place, xerr=[[gain - low], [high - gain]], fmt="o", color=plotting.COLOURS[0], capsize=3)
    axes.set_yticks(range(len(causes)), [" of ".join(filter(None, (c["effect"], c.get("target")))) for c in reversed(causes)])
    axes.set(xlabel="of the mean squared error [%]", title="what each cause saves", ylim=(-0.5, len(causes) - 0.5))


def plot_evidence(axes, evidence, against):
    part = evidence.where("against", against)
    for side, colour in (("before", plotting.COLOURS[1]), ("after", plotting.COLOURS[0])):
        axes.errorbar(part["center"], part[side], yerr=part[f"{side}_ci95"], color=colour, label=side, linewidth=1, elinewidth=0.6)
    axes.axhline(0, color="black", linewidth=0.8)
    axes.set(xlabel=against, ylabel="mean residual")
    axes.legend()


def plot_self_test(axes, test):
    axes.imshow(test["count"], cmap="viridis", aspect="auto")
    for row, counts in enumerate(test["count"]):
        for column, count in enumerate(counts):
            if count:
                axes.text(column, row, count, ha="center", va="center", color="white", fontsize=6)
    axes.set_xticks(range(len(test["answers"])), test["answers"], rotation=90, fontsize=5)
    axes.set_yticks(range(len(test["hidden"])), test["hidden"], fontsize=5)
    axes.set(xlabel="named", ylabel="hidden", title="self-test")


def draw(run):
    result, evidence = run.result, run.table("evidence.csv")
    channels, causes, test = evidence.distinct("against"), result["causes"], result.get("self_test")
    figure, axes = plotting.panels(1 + bool(causes) + len(channels) + bool(test))
    panel = iter(axes)
    plot_gap(next(panel), result)
    if causes:
        plot_gains(next(panel), causes)
    for against in channels:
        plot_evidence(next(panel), evidence, against)
    if test:
        plot_self_test(next(panel), test)
    return figure


if __name__ == "__main__":
    plotting.main(__doc__, draw, "diagnosis.pdf")
