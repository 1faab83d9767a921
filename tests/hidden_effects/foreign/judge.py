#!/usr/bin/env python3
"""Judge of the diagnosis on the independent population.

  judge.py run --generator build/release/bin/foreign_generator --driftwise build/release/bin/driftwise \
      --size quick --work /tmp/foreign            generate, diagnose, record, report; resumes by number
  judge.py run --dir DIR --driftwise PROGRAM --work WORK     data sets that are there, with DIR/key.jsonl
  judge.py report --work WORK [--markdown]        rates of what is recorded
  judge.py compare --before WORK --after WORK     paired counts and McNemar's test
  judge.py rekey --work WORK --generator PROGRAM  keys made again from the recorded orders, nothing diagnosed

WORK holds data/NUMBER/*.csv with its key and results.jsonl, one line per data set.
Exit code: 0 done, 1 done and a promise is refuted by its interval (with --promises) or a key is not the
recorded one (rekey), 2 usage.
"""
import argparse
import json
import os
import subprocess
import sys
import tempfile
import threading
import time

import judge_report

SIZES = {
    # null, singles per cause and strength, pairs, unlisted, pairs of units
    "quick": {"null": 60, "single": 1, "pair": 14, "unlisted": 18, "units": 6},
    "paired": {"null": 120, "single": 2, "pair": 28, "unlisted": 36, "units": 0},
    "night": {"null": 500, "single": 10, "pair": 50, "unlisted": 30, "units": 25},
    "full": {"null": 2000, "single": 40, "pair": 200, "unlisted": 120, "units": 100},
    "nulls": {"null": 2000, "single": 0, "pair": 0, "unlisted": 0, "units": 0},
}
SEED_BASE = {"quick": 1000000, "paired": 1900000, "night": 2000000, "full": 3000000,
             "nulls": 5800000}
# Strengths of singles (promise 95 and 98 %), pairs and unlisted effects.
SINGLE_CHI2 = (75, 150)
PAIR_CHI2 = 200
UNLISTED_CHI2 = 150
TIME_LIMIT_S = 600


def listed(generator, title):
    out = subprocess.run([generator, "--list"], check=True, capture_output=True, text=True).stdout
    return [line.split()[1] for line in out.splitlines() if line.split()[0] == title]


def orders(generator, size, seed_base):
    """Orders of one size, spread so that a part of the run is balanced too."""
    counts = SIZES[size]
    causes = listed(generator, "cause")
    unlisted = listed(generator, "unlisted")
    made = []

    def add(kind, k, total, **more):
        # A seventh of the two large counts is on plans and robots that no other size ever uses.
        reserved = size in ("full", "nulls") and k % 7 == 6
        made.append({"kind": kind, "place": (k + 0.5) / total, "reserved": reserved, **more})

    for k in range(counts["null"]):
        add("null", k, counts["null"])
    for chi2 in SINGLE_CHI2:
        total = counts["single"] * len(causes)
        for k in range(total):
            add("single", k, total, cause=causes[k % len(causes)], chi2=chi2)
    for k in range(counts["pair"]):
        add("pair", k, counts["pair"], cause=causes[(5 * k + 2) % len(causes)], chi2=PAIR_CHI2)
    for k in range(counts["unlisted"]):
        add("unlisted", k, counts["unlisted"], cause=unlisted[k % len(unlisted)], chi2=UNLISTED_CHI2)
    for k in range(counts["units"]):
        kind = "null" if k % 2 else "single"
        more = {} if k % 2 else {"cause": causes[(3 * k) % len(causes)], "chi2": 150}
        for units in ("study", "random"):
            add(kind, k, counts["units"], units=units, twin=k, **more)
    made.sort(key=lambda order: (order["place"], order["kind"], order.get("chi2", 0)))
    for number, order in enumerate(made):
        order["number"] = number
        # Twins share a seed: the same readings in other units and under other names.
        order["seed"] = seed_base + (900000 + order["twin"] if "twin" in order else number)
    return made


def generate(generator, order, folder):
    os.makedirs(folder, exist_ok=True)
    key_path = os.path.join(folder, "key.jsonl")
    if os.path.exists(key_path):
        os.remove(key_path)
    command = [generator, "--first-seed", str(order["seed"]), "--kind", order["kind"], "--out", folder]
    for name in ("cause", "chi2", "units"):
        if name in order:
            command += ["--" + name, str(order[name])]
    if order.get("reserved"):
        command.append("--reserved")
    if "twin" in order:
        command += ["--vary", "all"]
    done = subprocess.run(command, capture_output=True, text=True)
    with open(key_path) as lines:
        text = lines.read().strip()
    if not text:
        return None, done.stderr.strip()
    return json.loads(text.splitlines()[-1]), ""


def timed(command):
    """Runs a program; its exit code, output, errors, processor time and wall time."""
    begin = time.monotonic()
    child = subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE)
    texts = [b"", b""]
    readers = [threading.Thread(target=lambda k=k, s=s: texts.__setitem__(k, s.read()))
               for k, s in enumerate((child.stdout, child.stderr))]
    for reader in readers:
        reader.start()
    limit = threading.Timer(TIME_LIMIT_S, child.kill)
    limit.start()
    _, status, usage = os.wait4(child.pid, 0)
    child.returncode = os.waitstatus_to_exitcode(status)
    limit.cancel()
    for reader in readers:
        reader.join()
    return (child.returncode, texts[0].decode(), texts[1].decode(),
            usage.ru_utime + usage.ru_stime, time.monotonic() - begin)


def diagnose(driftwise, key, folder):
    command = [driftwise, "diagnose", os.path.join(folder, key["file"]), "--baseline", key["baseline"], "--json"]
    code, out, err, cpu_s, wall_s = timed(command)
    result = {"exit": code, "cpu_s": round(cpu_s, 3), "wall_s": round(wall_s, 3)}
    try:
        said = json.loads(out)
    except ValueError:
        result.update(verdict="none", findings=[], error=err.strip()[:500])
        return result
    result["verdict"] = said.get("verdict", "none")
    result["findings"] = [
        {"cause": f["cause"], "subject": f.get("subject"), "outputs": f.get("outputs", []),
         "indistinguishable_from": f.get("indistinguishable_from", []), "p_adjusted": f.get("p_adjusted")}
        for f in said.get("findings", [])]
    result["not_testable"] = [n.get("cause") for n in said.get("not_testable", [])]
    held_out = {}
    for side in ("baseline", "extended"):
        for output, figures in ((said.get(side) or {}).get("outputs") or {}).items():
            for name in ("a90_validation_nm", "a90_validation_arcsec", "rms_validation_nm",
                         "u90_validation_nm", "u90_validation_arcsec"):
                if isinstance(figures.get(name), (int, float)):
                    held_out.setdefault(output, {}).setdefault(side, figures[name])
                    break
    # The interval of the extended simulation's figure stands with each finding.
    for finding in said.get("findings", []):
        for output, figures in (finding.get("gain") or {}).items():
            for name in ("a90_ci90_nm", "a90_ci90_arcsec"):
                if name in figures and output in held_out:
                    held_out[output]["extended_ci90"] = figures[name]
    result["held_out"] = held_out
    return result


def run(args):
    os.makedirs(args.work, exist_ok=True)
    results_path = os.path.join(args.work, "results.jsonl")
    if args.fresh and os.path.exists(results_path):
        os.remove(results_path)
    done = {r["number"] for r in judge_report.read_results(results_path)}
    if args.dir:
        with open(os.path.join(args.dir, "key.jsonl")) as lines:
            work = [{"number": n, "key": json.loads(line)} for n, line in enumerate(lines) if line.strip()]
    else:
        work = orders(args.generator, args.size, args.seed_base or SEED_BASE[args.size])
    if args.units:
        work = [dict(order, units=args.units) for order in work if "twin" not in order]
    work = [order for order in work if order["number"] not in done and order["number"] % args.part_of == args.part]
    begin = time.monotonic()
    lock = threading.Lock()
    queue = iter(work)

    def worker():
        while args.minutes is None or time.monotonic() - begin < 60 * args.minutes:
            with lock:
                order = next(queue, None)
            if order is None:
                return
            folder = args.dir or os.path.join(args.work, "data", str(order["number"]))
            key, why = (order["key"], "") if "key" in order else generate(args.generator, order, folder)
            line = {"number": order["number"], "order": {k: v for k, v in order.items() if k != "key"}, "key": key}
            if key is None:
                line["refused"] = why
            else:
                line["result"] = diagnose(args.driftwise, key, folder)
                if not args.keep and not args.dir:
                    os.remove(os.path.join(folder, key["file"]))
            with lock, open(results_path, "a") as results:
                results.write(json.dumps(line) + "\n")
                if sys.stderr.isatty() or args.verbose:
                    said = line.get("result", {})
                    print(order["number"], order.get("kind", ""), order.get("cause", ""), said.get("verdict", why),
                          [f["cause"] for f in said.get("findings", [])], said.get("cpu_s"), file=sys.stderr)

    threads = [threading.Thread(target=worker) for _ in range(args.jobs)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    recorded = judge_report.read_results(results_path)
    left = len(work) - len([r for r in recorded if r["number"] in {o["number"] for o in work}])
    print(f"{len(recorded)} data sets recorded, {left} left")
    return judge_report.report(recorded, args.markdown, args.promises)


def extends(new, old):
    """Every figure of the old key is in the new one, unchanged."""
    if isinstance(old, dict):
        return isinstance(new, dict) and all(name in new and extends(new[name], old[name]) for name in old)
    if isinstance(old, list):
        return isinstance(new, list) and len(new) == len(old) and all(map(extends, new, old))
    return new == old


def rekey(work, generator):
    """Gives recorded results the key that this generator writes for their orders."""
    path = os.path.join(work, "results.jsonl")
    recorded = judge_report.read_results(path)
    if not recorded:
        print(f"{path}: no recorded result", file=sys.stderr)
        return 2
    new, other, without = 0, [], 0
    for line in recorded:
        if not line.get("key") or "seed" not in line["order"]:
            without += 1
            continue
        with tempfile.TemporaryDirectory() as folder:
            key, why = generate(generator, line["order"], folder)
        if key is None or not extends(key, line["key"]):
            other.append(f"{line['number']}{': ' + why if why else ''}")
            continue
        new += 1
        line["key"] = key
    with open(path + ".new", "w") as results:
        for line in recorded:
            results.write(json.dumps(line) + "\n")
    os.replace(path + ".new", path)
    print(f"{new} keys made again, {len(other)} not the recorded ones and left as they were, {without} without an order")
    if other:
        print("not the recorded key: " + ", ".join(other))
    return 1 if other else 0


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    verbs = parser.add_subparsers(dest="verb", required=True)
    runs = verbs.add_parser("run")
    runs.add_argument("--generator", default="build/release/bin/foreign_generator")
    runs.add_argument("--driftwise", default="build/release/bin/driftwise")
    runs.add_argument("--size", choices=sorted(SIZES), default="quick")
    runs.add_argument("--dir")
    runs.add_argument("--seed-base", type=int, help="other seeds than the size's own")
    runs.add_argument("--units", choices=("study", "random"), help="all data sets in these units and names")
    runs.add_argument("--jobs", type=int, default=1)
    runs.add_argument("--part", type=int, default=0, help="this part of --part-of, by number")
    runs.add_argument("--part-of", type=int, default=1)
    runs.add_argument("--minutes", type=float, help="start no data set after so long; resume later")
    runs.add_argument("--fresh", action="store_true", help="forget what WORK has recorded (another program)")
    runs.add_argument("--keep", action="store_true", help="keep the data sets")
    runs.add_argument("--verbose", action="store_true")
    reports = verbs.add_parser("report")
    compares = verbs.add_parser("compare")
    compares.add_argument("--before", required=True)
    compares.add_argument("--after", required=True)
    rekeys = verbs.add_parser("rekey")
    rekeys.add_argument("--work", required=True)
    rekeys.add_argument("--generator", default="build/release/bin/foreign_generator")
    for verb in (runs, reports):
        verb.add_argument("--work", required=True)
        verb.add_argument("--markdown", action="store_true")
        verb.add_argument("--promises", action="store_true", help="exit 1 when an interval excludes a promise")
    args = parser.parse_args()
    if args.verb == "run":
        return run(args)
    if args.verb == "rekey":
        return rekey(args.work, args.generator)
    if args.verb == "report":
        results = judge_report.read_results(os.path.join(args.work, "results.jsonl"))
        return judge_report.report(results, args.markdown, args.promises)
    return judge_report.compare(*(judge_report.read_results(os.path.join(folder, "results.jsonl"))
                                  for folder in (args.before, args.after)))


if __name__ == "__main__":
    sys.exit(main())
