#!/usr/bin/env python3
"""Prints the tables of docs/results.md from the cells of a benchmark: scripts/results.py DIR, where
scripts/benchmark.sh --config out=DIR ran. Geometric means over seeds."""
import json
import math
import sys
import tomllib
from pathlib import Path

SCENES = Path(__file__).resolve().parent.parent / "scenes"

STUDENT_90 = {2: 6.314, 3: 2.920, 4: 2.353, 5: 2.132}  # quantile of 95 % by number of seeds


def mean(values):
    return sum(values) / len(values)


def geometric(values):
    return math.exp(mean([math.log(v) for v in values]))


def interval(values):
    """90 % interval of the geometric mean of independent values."""
    logs = [math.log(v) for v in values]
    middle, n = mean(logs), len(logs)
    if n not in STUDENT_90:
        return math.nan, math.nan
    half = STUDENT_90[n] * math.sqrt(sum((x - middle) ** 2 for x in logs) / (n - 1) / n)
    return math.exp(middle - half), math.exp(middle + half)


def number(x):
    if math.isnan(x):
        return "–"
    if 0.01 <= x < 1e4:
        return f"{x:.2g}" if x < 100 else f"{x:.0f}"
    digits, exponent = f"{x:.1e}".split("e")
    return f"{digits}e{int(exponent)}"


def row(cells):
    print("| " + " | ".join(cells) + " |")


class Truth:
    """The cells of one truth, one per seed."""

    def __init__(self, name, files):
        self.name = name
        self.files = files
        self.cells = [json.loads(file.read_text()) for file in files]
        self.horizons = self.cells[0]["horizons_s"]
        self.friction = tomllib.loads((SCENES / f"{name}.toml").read_text())["friction"]["law"]
        self.models = {s["name"]: [next(x for x in cell["summary"] if x["name"] == s["name"]) for cell in self.cells]
                       for s in self.cells[0]["summary"]}

    def errors(self, model, h):
        return [s["q_mse_geometric_mean"][h] for s in self.models[model]]

    def best_conventional(self, h, family=True):
        """@param family  laws that the truth's friction has, too"""
        own = [] if family else [law["law"] for law in self.friction]
        names = [m for m, s in self.models.items() if s[0]["is_conventional"] and m not in own]
        return min(names, key=lambda m: geometric(self.errors(m, h)))

    def of(self, model, key):
        return [s[key] for s in self.models[model]]


def open_loop(truths, h):
    row([f"truth, {truths[0].horizons[h]:.3g} s", "oracle", "best conventional", "gms (windows)", "known law", "lvm",
         "lvm / known law", "conventional / lvm", "of other laws than the truth's / lvm"])
    row(["---"] + ["--:"] * 8)
    for truth in truths:
        best = truth.best_conventional(h)
        lvm, known = geometric(truth.errors("lvm", h)), geometric(truth.errors("known_law", h))
        conventional = geometric(truth.errors(best, h))
        low, high = interval(truth.errors("lvm", h))
        ratio = [a / b for a, b in zip(truth.errors("lvm", h), truth.errors("known_law", h))]
        of_ratio = interval(ratio)
        other = truth.best_conventional(h, family=False)
        row([truth.name, number(geometric(truth.errors("simulator", h))), f"{number(conventional)} ({best})",
             number(geometric(truth.errors("gms_windows", h))), number(known),
             f"{number(lvm)} ({number(low)} … {number(high)})",
             f"{lvm / known:.2f} ({of_ratio[0]:.2f} … {of_ratio[1]:.2f})", number(conventional / lvm),
             f"{number(geometric(truth.errors(other, h)) / lvm)} ({other})"])
    print()


def shares(truths):
    horizons = truths[0].horizons
    row(["truth"] + [f"bands {h:.3g} s [%]" for h in horizons] +
        [f"headroom closed, {h:.3g} s: {m}" for h in horizons[2:] for m in ("lvm", "known law")] + ["friction in rollouts [%]", "known law", "reversals / oracle", "diverged"])
    row(["---"] + ["--:"] * (3 * len(horizons)))
    bands = []
    for truth in truths:
        own = [100 * mean([b[h] for b in truth.of("lvm", "band_coverage")]) for h in range(len(horizons))]
        bands.append(own)
        rollout = {m: 100 * mean(truth.of(m, "friction_rollout")) for m in ("lvm", "known_law")}
        closed = [mean([c[h] for c in truth.of(m, "headroom_closed")]) for h in range(2, len(horizons))
                  for m in ("lvm", "known_law")]
        reversal = mean([a / b for a, b in zip(truth.of("lvm", "friction_reversal"), truth.of("oracle", "friction_reversal"))])
        row([truth.name] + [f"{b:.0f}" for b in own] +
            [f"{c:.2f}" for c in closed] +
            [f"{rollout['lvm']:.2f}", f"{rollout['known_law']:.2f}",
             f"{reversal:.2f}", str(sum(truth.of("lvm", "diverged")))])
    row(["mean"] + [f"{mean([b[h] for b in bands]):.0f}" for h in range(len(horizons))] + [""] * (2 * len(horizons)))
    print()


def intervals(truths):
    kinds = ["base", "friction", "elements"]
    columns = [(kind, model) for kind in kinds for model in ("simple", "lvm", "known_law") if kind == "base" or model != "simple"]
    row(["truth"] + [f"{kind}: {model}" for kind, model in columns])
    row(["---"] + ["--:"] * len(columns))
    sums = [[0, 0] for _ in columns]
    for truth in truths:
        cells = [truth.name]
        for (kind, model), total in zip(columns, sums):
            found = truth.of(model, "intervals")
            hold, stated = (sum(i[kind][key] for i in found) for key in ("hold", "stated"))
            if kind == "friction":  # elements of a bank have columns of their own
                hold, stated = (n - sum(i["elements"][key] for i in found) for n, key in ((hold, "hold"), (stated, "stated")))
            total[0] += hold
            total[1] += stated
            cells.append(f"{hold} of {stated}" if stated else "–")
        row(cells)
    row(["all"] + [f"{100 * hold / stated:.1f} %" if stated else "–" for hold, stated in sums])
    print()


def wrong_parts(truths):
    """Parts of the lvm that are on though the truth, a law without modifiers, lacks them, and what they cost: the known
    law has the parts of the truth alone."""
    modifiers = {"load", "power_flow", "asymmetry", "ripple", "temperature", "backlash"}
    parts = modifiers | {"gear_load", "second_ripple", "third_ripple", "network"}
    row(["truth without modifiers", "parts on that it lacks", "lvm / known law, 10 s", "full length"])
    row(["---"] + ["--:"] * 3)
    for truth in truths:
        if any(modifiers & law.keys() for law in truth.friction):
            continue
        fits = [json.loads((file.parent / "fit/lvm_s1.json").read_text()) for file in truth.files]
        sums = [fit for fit in fits if any(c["taken"] and c["name"].startswith("sum") for c in fit["candidates"])]
        found = [part["on"] for fit in sums for part in fit["parts"] if part["part"] in parts]
        ratio = [geometric(truth.errors("lvm", h)) / geometric(truth.errors("known_law", h)) for h in (2, 3)]
        row([truth.name, f"{sum(found)} of {len(found)} in {len(sums)} sums"] + [f"{r:.2f}" for r in ratio])
    print()


def main():
    folder = Path(sys.argv[1])
    cells = {}
    for file in sorted(folder.glob("*_[0-9]*/evaluation.json")):
        cells.setdefault(file.parent.name.rsplit("_", 1)[0], []).append(file)
    order = ["kr6_lugre", "kr6_gms", "kr6_load", "kr6_thermal", "kr6_full"]
    names = sorted(cells, key=lambda name: (order.index(name) if name in order else len(order), name))
    truths = [Truth(name, cells[name]) for name in names]
    for h in range(2, len(truths[0].horizons)):
        open_loop(truths, h)
    shares(truths)
    intervals(truths)
    wrong_parts(truths)


if __name__ == "__main__":
    main()
