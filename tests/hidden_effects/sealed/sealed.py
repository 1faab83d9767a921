#!/usr/bin/env python3
"""Sealed effects on the wire: for each number a cell hides causes that are drawn with it, `driftwise improve` measures and
looks for them over the devices' own protocols, and only then the sealed answer is opened.

sealed.py BIN_DIR SOURCE_DIR [--robot linear-axis] [--effects 25] [--first-seed 1] [--out DIR] [--table FILE]

Resumable by number: what stands in DIR/ROBOT-SEED.json is not measured again; its run and the plant's log stay beside it. A
cause is found when a finding has its name and its place, in the set when it stands among those that the report cannot separate
from a finding. Exit code 1: fewer than 85 % of those above chi2 75 are found or in the set.

Strength: what the mechanism added at the measured points, from the plant's own log, less what the baseline's terms take of it
by least squares, over the white part of the noise: chi2. Of a broken thermometer there is no such log: it always counts.
"""
import argparse
import bisect
import csv
import datetime
import itertools
import json
import math
import pathlib
import subprocess
import sys
import time

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[2] / "faults" / "campaign"))
from cell import Cell, Trouble  # noqa: E402

LIMIT_S = 240
STRONG = 75
# The catalogue has each of them once, whatever moves: they have no place, or that of an only axis.
ONCE = ("step_change", "periodic_disturbance", "instrument_drift")

# How each robot is measured: the words that make the plan, the seconds at each place, the model at its beginning, the speed.
ROBOTS = {
    "linear-axis": {"plan": ["generate", "--axis", "q1_mm=-3.9:3.9:18", "--both-directions", "--repeat", "14", "--validation"],
                    "dwell_s": 22, "model": "q ~ x + x^2 + T", "speed": 400},
    # Five levels, for the model is of the fourth degree.
    "micro-nano": {"plan": ["generate", "--axis", "q1_mm=0:2.5:5", "--axis", "q2_mm=0:2.5:5", "--axis", "q3_mm=0:2.5:5", "--both-directions",
                            "--repeat", "2", "--validation"],
                   "dwell_s": 20, "model": "q ~ poly(x, y, z, 4) + t04..t10 + t04:poly(x, y, z, 2)", "speed": 200},
}


def with_dwell(text, dwell_s):
    lines, header = [], False
    for line in text.splitlines():
        if line.startswith("#") or not line:
            lines.append(line)
            continue
        lines.append(line + (",%g" % dwell_s if header else ",dwell_s"))
        header = True
    return "\n".join(lines) + "\n"


def powers(degree):
    """Exponents of x, y and z of a polynomial of this degree, without the constant."""
    return [e for e in itertools.product(range(degree + 1), repeat=3) if 0 < sum(e) <= degree]


def baseline_terms(robot, row):
    """The values of the terms of ROBOTS[robot]["model"] in a row, the constant first. A thermometer that was never read has no column."""
    temperatures = lambda first: [row[name] for name in ("t%02d_degC" % i for i in range(first, 11)) if name in row]
    if robot == "linear-axis":
        return [1, row["x_mm"], row["x_mm"] ** 2] + temperatures(1)
    of = lambda e: row["x_mm"] ** e[0] * row["y_mm"] ** e[1] * row["z_mm"] ** e[2]
    kelvin = temperatures(4)
    return [1] + [of(e) for e in powers(4)] + kelvin + [kelvin[0] * of(e) for e in powers(2)]


def dot(a, b):
    return sum(x * y for x, y in zip(a, b))


def beyond(columns, values):
    """values without what columns of length one, each at right angles to the others, take of them."""
    for column in columns:
        along = dot(column, values)
        values = [v - along * c for v, c in zip(values, column)]
    return values


def of_length_one(columns):
    """Gram and Schmidt, each column twice; those that the ones before span are left out."""
    basis = []
    for column in columns:
        mean = sum(column) / len(column)
        if any(one != column[0] for one in column):
            column = [one - mean for one in column]
        before = math.sqrt(dot(column, column))
        left = beyond(basis, beyond(basis, column))
        length = math.sqrt(dot(left, left))
        if length > 1e-9 * before:
            basis.append([one / length for one in left])
    return basis


def strengths(given, run_csv, truth_csv, hidden):
    """chi2 of each hidden cause beside the baseline; None where the plant has no log of it."""
    lines = run_csv.splitlines()
    zero = next(line for line in lines if line.startswith("# time_zero:")).split(": ")[1]
    seconds, _, fraction = zero.rstrip("Z").partition(".")
    begun = datetime.datetime.fromisoformat(seconds + "+00:00").timestamp() + float("0." + fraction)
    rows = [{name: float(value) if value.replace(".", "").replace("-", "").replace("e", "").isdigit() else value for name, value in row.items()}
            for row in csv.DictReader(line for line in lines if not line.startswith("#"))]
    at_s = [begun + row["time_s"] for row in rows]
    ticks = [row for row in csv.DictReader(truth_csv.splitlines()) if row["kind"] == "tick" and None not in row.values()]
    tick_s = [int(row["time_ns"]) / 1e9 for row in ticks]
    columns = list(zip(*(baseline_terms(given.robot, row) for row in rows)))
    basis = of_length_one([list(column) for column in columns])
    added = {}
    for number in range(1, len(hidden) + 1):
        name = "hidden_h%d_nm" % number
        if name in ticks[0]:
            added[number] = beyond(basis, [float(ticks[min(bisect.bisect(tick_s, at), len(ticks) - 1)][name]) for at in at_s])
    with_truth = basis + of_length_one([beyond(basis, one) for one in added.values()])
    noise = []
    for q in ("q1_mm", "q2_mm", "q3_mm"):
        if q in rows[0]:
            left = beyond(with_truth, [1e6 * row[q] for row in rows])
            noise.append(sum((a - b) ** 2 for a, b in zip(left, left[1:])) / (2 * (len(left) - 1)))
    return [dot(added[number], added[number]) / min(noise) if number in added else None for number in range(1, len(hidden) + 1)]


def measure(given, seed):
    robot, begun = ROBOTS[given.robot], time.monotonic()
    with Cell(given.programs, given.source, kind=given.robot, speed=robot["speed"], seed=seed,
              plant_words=["--hide", "random", "--sealed", "sealed.json"]) as cell:
        cell.start()
        grid, plan = cell.folder / "grid.csv", cell.folder / "plan.csv"
        made = cell.cli("trajectory", *robot["plan"], "-o", grid)
        if made.returncode != 0:
            raise Trouble(made.stderr)
        plan.write_text(with_dwell(grid.read_text(), robot["dwell_s"]))
        improved = cell.cli("improve", plan, "--model", robot["model"], "--max-turns", 1, "--json", seconds=LIMIT_S)
        shown = cell.cli("diagnosis", "show", 1, "--json")
        if not shown.stdout:
            raise Trouble("no diagnosis: %s %s" % (improved.stderr.strip(), shown.stderr.strip()))
        seconds = round(time.monotonic() - begun)
        run = cell.folder / "run.csv"
        exported = cell.cli("data", "export", 1, "-o", run)
        if exported.returncode != 0:
            raise Trouble(exported.stderr)
        hidden = json.loads((cell.folder / "sealed.json").read_text())["hidden"]
        for one, chi2 in zip(hidden, strengths(given, run.read_text(), (cell.folder / "truth.csv").read_text(), hidden)):
            one["chi2"] = chi2
        (pathlib.Path(given.out) / ("%s-%d.csv" % (given.robot, seed))).write_text(run.read_text())
    return {"seed": seed, "seconds": seconds, "hidden": hidden, "diagnosis": json.loads(shown.stdout)}


def verdict_of(hidden, findings):
    """exact, in the set, elsewhere (the right cause at another place) or missed."""
    for one in findings:
        there = one.get("symbol", one.get("subject", "")).startswith(hidden["symbol"])
        if one.get("cause") == hidden["cause"] and (there or hidden["cause"] in ONCE):
            return "exact"
    name = hidden["cause"] if hidden["cause"] in ONCE else "%s %s" % (hidden["cause"], hidden["symbol"])
    if any(other.startswith(name) for one in findings for other in one.get("indistinguishable_from", [])):
        return "in the set"
    return "elsewhere" if any(one.get("cause") == hidden["cause"] for one in findings) else "missed"


def is_strong(hidden):
    return hidden.get("chi2") is None or hidden["chi2"] > STRONG


def beside(result):
    """Findings that name nothing hidden."""
    causes = [one["cause"] for one in result["hidden"]]
    return [one for one in result["diagnosis"].get("findings", [])
            if one.get("cause") not in causes and not any(other.startswith(tuple(causes)) for other in one.get("indistinguishable_from", []))]


def main():
    words = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    words.add_argument("programs")
    words.add_argument("source")
    words.add_argument("--robot", default="linear-axis", choices=sorted(ROBOTS))
    words.add_argument("--effects", type=int, default=25)
    words.add_argument("--first-seed", type=int, default=1)
    words.add_argument("--out", default="out/sealed")
    words.add_argument("--table")
    given = words.parse_args()
    folder = pathlib.Path(given.out)
    folder.mkdir(parents=True, exist_ok=True)
    results = []
    for seed in range(given.first_seed, given.first_seed + given.effects):
        kept = folder / ("%s-%d.json" % (given.robot, seed))
        if not kept.exists():
            try:
                kept.write_text(json.dumps(measure(given, seed)))
            except (Trouble, subprocess.TimeoutExpired, ValueError) as trouble:
                print("%s seed %d: %s" % (given.robot, seed, trouble), flush=True)
                kept.write_text(json.dumps({"seed": seed, "trouble": str(trouble)}))
        result = json.loads(kept.read_text())
        results.append(result)
        if "trouble" not in result:
            findings = result["diagnosis"].get("findings", [])
            print("%s seed %d, %d s: %s" % (given.robot, seed, result["seconds"], "; ".join(
                "%s %s %g %s: %s" % (one["cause"], one["symbol"], one["size"], one["unit"], verdict_of(one, findings)) for one in result["hidden"])), flush=True)
    lines = ["# Sealed effects on the wire: %s" % given.robot, "",
             "`tests/hidden_effects/sealed/sealed.py BIN SOURCE --robot %s --effects %d --first-seed %d`, %s. Sizes are the mechanism's own; chi2 is what the baseline leaves of it over the noise." %
             (given.robot, given.effects, given.first_seed, datetime.date.today()), "",
             "| seed | hidden | chi2 | found | named beside it | seconds |", "|---|---|---|---|---|---|"]
    counts = {"exact": 0, "in the set": 0, "elsewhere": 0, "missed": 0}
    weak = dict(counts)
    troubles = 0
    for result in results:
        if "trouble" in result:
            troubles += 1
            lines.append("| %d | | | not measured: %s | | |" % (result["seed"], result["trouble"].splitlines()[0] if result["trouble"] else ""))
            continue
        findings = result["diagnosis"].get("findings", [])
        for one in result["hidden"]:
            verdict = verdict_of(one, findings)
            (counts if is_strong(one) else weak)[verdict] += 1
            chi2 = "" if one.get("chi2") is None else "%.0f" % one["chi2"]
            lines.append("| %d | %s, %s, %g %s | %s | %s | %s | %d |" % (result["seed"], one["cause"], one["symbol"], one["size"], one["unit"], chi2, verdict,
                                                                   "; ".join(other.get("cause", "") for other in beside(result)), result["seconds"]))
    total = sum(counts.values())
    false = sum(len(beside(result)) for result in results if "trouble" not in result)
    share = (counts["exact"] + counts["in the set"]) / total if total else 0
    lines += ["", "Above chi2 %d: found exactly %d, in the set %d, at another place %d, missed %d of %d (%.0f %%; wanted 85). Below: %d of %d found. Named and not hidden: %d. Not measured: %d." %
              (STRONG, counts["exact"], counts["in the set"], counts["elsewhere"], counts["missed"], total, 100 * share, weak["exact"] + weak["in the set"],
               sum(weak.values()), false, troubles)]
    print(lines[-1])
    if given.table:
        pathlib.Path(given.table).write_text("\n".join(lines) + "\n")
    return 0 if share >= 0.85 and troubles == 0 else 1


if __name__ == "__main__":
    sys.exit(main())
