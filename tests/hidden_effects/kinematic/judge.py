#!/usr/bin/python3
"""Judge of `driftwise diagnose` on the data sets of generate.py.

  judge.py run --driftwise PROGRAM --work WORK DIR...     diagnose and report; resumes by file name
  judge.py report --work WORK [--misses] DIR...           rates of what is recorded

DIR holds data sets and key.jsonl. WORK holds results.jsonl, one line per data set: another program,
another WORK.
"""
import argparse
import json
import os
import queue
import subprocess
import sys
import threading
import time

from judge_report import report


def read_lines(path):
    """Objects of a .jsonl file; a last line that a stopped run left unfinished is dropped."""
    if not os.path.exists(path):
        return []
    with open(path) as lines:
        texts = [line for line in lines if line.endswith("\n")]
    return [json.loads(text) for text in texts]


def read_keys(folders):
    """Per folder a list of (file, path, key)."""
    found = []
    for folder in folders:
        path = os.path.join(folder, "key.jsonl")
        if not os.path.exists(path):
            sys.exit("%s: no such file; DIR is a folder that generate.py wrote" % path)
        found.append([(k["file"], os.path.join(folder, k["file"]), k) for k in read_lines(path)])
    return found


def diagnose(program, path, key, limit_s):
    command = [program, "diagnose", path, "--baseline", key["baseline"], "--json"]
    begin = time.monotonic()
    try:
        done = subprocess.run(command, capture_output=True, text=True, timeout=limit_s)
        code, out, err = done.returncode, done.stdout, done.stderr
    except subprocess.TimeoutExpired:
        code, out, err = "timeout", "", ""
    result = {"file": key["file"], "exit": code, "wall_s": round(time.monotonic() - begin, 2)}
    try:
        said = json.loads(out)
    except ValueError:
        said = {}
    if "verdict" not in said:
        error = (err.strip() or out.strip())[-500:]
        return dict(result, verdict="none", findings=[], baseline={}, extended={}, error=error)
    names = ("cause", "subject", "outputs", "parameters", "indistinguishable_from", "gain")
    findings = [{name: f.get(name) for name in names} for f in said.get("findings", [])]
    for finding in findings:
        for value in (finding["parameters"] or {}).values():
            if isinstance(value, dict):
                value.pop("curve", None)
    return dict(
        result,
        verdict=said["verdict"],
        findings=findings,
        baseline=(said.get("baseline") or {}).get("outputs") or {},
        extended=(said.get("extended") or {}).get("outputs") or {},
    )


def run(args):
    os.makedirs(args.work, exist_ok=True)
    results_path = os.path.join(args.work, "results.jsonl")
    recorded = read_lines(results_path)
    with open(results_path, "w") as results:
        results.writelines(json.dumps(r) + "\n" for r in recorded)
    done = {r["file"] for r in recorded}
    orders = []
    for items in read_keys(args.dirs):
        left = [item for item in items if item[0] not in done]
        # all folders in turn, so that a stopped run is balanced
        orders += [((n + 0.5) / len(left), *item) for n, item in enumerate(left)]
    work = queue.Queue()
    for order in sorted(orders, key=lambda order: order[:2]):
        work.put(order[1:])
    begin = time.monotonic()
    lock = threading.Lock()

    def worker():
        while args.minutes is None or time.monotonic() - begin < 60 * args.minutes:
            try:
                _, path, key = work.get_nowait()
            except queue.Empty:
                return
            result = diagnose(args.driftwise, path, key, args.limit)
            with lock, open(results_path, "a") as results:
                results.write(json.dumps(result) + "\n")

    threads = [threading.Thread(target=worker) for _ in range(args.jobs)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()


def main():
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    verbs = parser.add_subparsers(dest="verb", required=True)
    runs = verbs.add_parser("run")
    runs.add_argument("--driftwise", required=True, help="the program")
    runs.add_argument("--jobs", type=int, default=1, help="data sets at a time")
    runs.add_argument("--minutes", type=float, help="start no data set after so long")
    runs.add_argument("--limit", type=float, default=600, help="seconds for one data set")
    for verb in (runs, verbs.add_parser("report")):
        verb.add_argument("--work", required=True)
        verb.add_argument("--misses", action="store_true", help="print what was not right")
        verb.add_argument("dirs", nargs="+", metavar="DIR")
    args = parser.parse_args()
    if args.verb == "run":
        run(args)
    keys = {name: (path, key) for items in read_keys(args.dirs) for name, path, key in items}
    recorded = {r["file"]: r for r in read_lines(os.path.join(args.work, "results.jsonl"))}
    report(recorded, keys, args.misses)


if __name__ == "__main__":
    main()
