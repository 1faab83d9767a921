#!/usr/bin/env python3
"""Spread of the figures that demos print, and whether one more demo lies inside it.

demo_spread.py DEMO.txt ... [--judge ONE.txt]: printed output of `deploy/demo.sh` or `deploy/demo.sh micro-nano`, one file per demo.
A table of every S90 and A90 (nm): n, mean, standard deviation, smallest, largest, 95 % prediction interval of one more demo
(mean +- t(0.975, n - 1) s sqrt(1 + 1 / n), normal distribution). --judge: each figure of one more demo against both. With m figures
5 % of m are expected outside the prediction interval, and 2 m / (n + 1) outside smallest to largest. Exit code 1: a figure is
outside the prediction interval by Bonferroni's t(1 - 0.025 / m, n - 1), so that 95 % of whole demos pass."""
import argparse
import math
import re
import statistics
import sys

FIGURE = r"(\d+\.\d) \([+-]\d+\.\d, (\d+\.\d)\)"  # A90 (mean, S90)


def figures_of(name):
    """{what: nm} of one printed demo, in the order of the print."""
    with open(name, encoding="utf-8") as file:
        lines = file.read().splitlines()
    found = {}

    def take(what, value):
        found.setdefault(what, float(value))

    proof = ""
    for line in lines:
        if row := re.match(r"(geometry only|geometry \+ 10 temperatures|only the 6 sensors on the robot|first 300 points only, "
                           r"10 temperatures) +\d+ +(\d+\.\d) +(\d+\.\d) +\d+ ", line):
            take(f"fit, {row[1]}: S90 validation", row[2])
            take(f"fit, {row[1]}: S90 by blocks", row[3])
        elif row := re.match(r"(without compensation \(q = x\)|geometry only|ten sensors|six sensors on the robot) +\d+ +\d+\.\d+ K +"
                             + FIGURE + " +" + FIGURE, line):
            take(f"proof, {row[1]}: A90 interferometer", row[2])
            take(f"proof, {row[1]}: A90 truth", row[4])
        elif row := re.match(r"(G|G \+ F|G \+ T|G \+ T \+ F|  and products of force and t04 with the pose)  +(.*) ms$", line):
            for axis, value in zip(("q1", "q2", "q3"), re.findall(r"(\d+\.\d) \( ?\d+\)", row[2])[-3:]):
                take(f"fit, {row[1].strip()}: S90 {axis}", value)
        elif row := re.match(r"(?:\.\.\. (outside)|  (products))  +.*?(\d+\.\d) +(\d+\.\d) +(\d+\.\d) *$", line):
            for axis, value in zip(("q1", "q2", "q3"), row.groups()[2:]):
                take(f"fit, G + T + F outside: S90 {axis}" if row[1] else f"fit, products outside: S90 {axis}", value)
        elif row := re.match(r"(.+): \d+ points under \d", line):
            proof = row[1]
        elif proof and (row := re.match(r"  ([xyz]) +(?:\d+ +)?" + FIGURE + " +" + FIGURE, line)):
            take(f"proof, {proof}: A90 {row[1]} instruments", row[2])
            take(f"proof, {proof}: A90 {row[1]} truth", row[4])
    if not found:
        sys.exit(f"{name}: found no table of a demo, expected the printed output of deploy/demo.sh")
    return found


def student(probability, degrees):
    """Quantile of Student's t, by bisection over its distribution integrated with Simpson's rule."""
    scale = math.exp(math.lgamma((degrees + 1) / 2) - math.lgamma(degrees / 2)) / math.sqrt(degrees * math.pi)

    def below(t, steps=2000):
        width = t / steps
        total = sum((1 if i in (0, steps) else 4 if i % 2 else 2) * (1 + (i * width) ** 2 / degrees) ** (-(degrees + 1) / 2)
                    for i in range(steps + 1))
        return 0.5 + scale * total * width / 3

    low, high = 0.0, 1000.0
    for _ in range(60):
        middle = (low + high) / 2
        low, high = (middle, high) if below(middle) < probability else (low, middle)
    return (low + high) / 2


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("demos", nargs="+")
    parser.add_argument("--judge", metavar="ONE.txt")
    asked = parser.parse_args()
    if len(asked.demos) < 3:
        sys.exit(f"{len(asked.demos)} demos: a spread needs three at least")
    demos = [figures_of(name) for name in asked.demos]
    names = [name for name in demos[0] if all(name in demo for demo in demos)]
    left_out = sorted({name for demo in demos for name in demo} - set(names))
    one = figures_of(asked.judge) if asked.judge else {}
    n, m = len(demos), len(names)
    t, t_whole = student(0.975, n - 1), student(1 - 0.025 / m, n - 1)
    print(f"{n} demos, {m} figures, nm; prediction interval of one more demo: 95 %, t = {t:.2f}\n")
    print("| figure | mean | s | smallest | largest | prediction |" + (" this | |" if one else ""))
    print("|---|---|---|---|---|---|" + ("---|---|" if one else ""))
    outside_range = outside = far = 0
    for name in names:
        values = [demo[name] for demo in demos]
        mean, s = statistics.mean(values), statistics.stdev(values)
        half = t * s * math.sqrt(1 + 1 / n)
        row = f"| {name} | {mean:.1f} | {s:.2f} | {min(values):.1f} | {max(values):.1f} | {max(0, mean - half):.1f} to {mean + half:.1f} |"
        if name in one:
            value = one[name]
            words = []
            if not min(values) <= value <= max(values):
                outside_range += 1
                words.append("outside smallest to largest")
            if abs(value - mean) > half + 0.05:  # printed to 0.1
                outside += 1
                words.append("outside the prediction interval")
            far += abs(value - mean) > half * t_whole / t + 0.05
            row += f" {value:.1f} | {', '.join(words) or 'inside'} |"
        print(row)
    for name in left_out:
        print(f"\nnot in every demo: {name}")
    if not asked.judge:
        return 0
    missing = [name for name in names if name not in one]
    print(f"\n{asked.judge}: {outside_range} of {m} outside smallest to largest (expected {2 * m / (n + 1):.1f}), {outside} outside the "
          f"prediction interval (expected {0.05 * m:.1f}), {far} outside the interval for all {m} together"
          + (f"; not printed: {', '.join(missing)}" if missing else ""))
    print("verdict:", "not inside the spread" if far or missing else "inside the spread")
    return 1 if far or missing else 0


if __name__ == "__main__":
    sys.exit(main())
