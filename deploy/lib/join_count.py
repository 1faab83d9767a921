#!/usr/bin/env python3
"""Errors of joined coordinates against their stated uncertainty, over several machines.

join_count.py SEED/join_truth.json ...: files of deploy/lib/join_count.sh, one per machine. A column per coordinate (nm, arcsec), a row
per figure: rms over the machines of the error at the plant's truth and of the stated u, their ratio, the worst machine, machines
within 2 u, and the same against six coordinates measured at once, which have the error of the lever arms too: error <=
sqrt(at_once^2 + (2 u)^2). Exit code 1: a machine beyond that; of rotations also a ratio above 1.5 or a machine beyond 2 u."""
import json
import math
import os
import sys

COORDINATES = ("rx", "ry", "rz", "x", "y", "z")


def rms(values):
    return math.sqrt(sum(value * value for value in values) / len(values))


def main():
    if len(sys.argv) < 2 or sys.argv[1].startswith("-"):
        sys.exit(__doc__)
    seeds, machines = [], []
    for name in sys.argv[1:]:
        seeds.append(os.path.basename(os.path.dirname(name)))
        with open(name, encoding="utf-8") as file:
            machines.append(json.load(file))
    rows = {title: [] for title in ("rms error", "stated u", "ratio", "worst machine (its seed)", "within 2 u", "largest single row",
                                    "six at once, rms error", "joined : sqrt(at once^2 + u^2)", "... worst machine (its seed)",
                                    "within sqrt(at once^2 + (2 u)^2)", "joined less at once, rms")}
    failed = False
    for coordinate in COORDINATES:
        of = [machine[coordinate] for machine in machines]
        digits = 1 if of[0]["unit"] == "nm" else 3
        error, u = [one["rms"] for one in of], [one["u"] for one in of]
        once = [one["at_once_rms"] for one in of]
        ratios = [e / v for e, v in zip(error, u)]
        against = [e / math.hypot(o, v) for e, o, v in zip(error, once, u)]
        ratio, within = rms(error) / rms(u), sum(one <= 2 for one in ratios)
        together = sum(e <= math.hypot(o, 2 * v) for e, o, v in zip(error, once, u))
        failed = failed or together < len(of) or (coordinate.startswith("r") and (ratio > 1.5 or within < len(of)))
        for title, text in zip(rows, (
                f"{rms(error):.{digits}f}", f"{rms(u):.{digits}f}", f"{ratio:.2f}", f"{max(ratios):.2f} ({seeds[ratios.index(max(ratios))]})",
                f"{within} of {len(of)}", f"{max(one['largest'] for one in of):.{digits}f}", f"{rms(once):.{digits}f}",
                f"{rms(error) / math.hypot(rms(once), rms(u)):.2f}", f"{max(against):.2f} ({seeds[against.index(max(against))]})",
                f"{together} of {len(of)}", f"{rms([one['less_at_once_rms'] for one in of]):.{digits}f}")):
            rows[title].append(text)
    print(f"{len(machines)} machines, seeds {', '.join(seeds)}; rotations in arcsec, lengths in nm\n")
    print("| | " + " | ".join(COORDINATES) + " |")
    print("|---" * (len(COORDINATES) + 1) + "|")
    for title, texts in rows.items():
        print(f"| {title} | " + " | ".join(texts) + " |")
    return 1 if failed else 0


if __name__ == "__main__":
    sys.exit(main())
