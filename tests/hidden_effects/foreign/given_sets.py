#!/usr/bin/env python3
"""Judges the diagnosis on the 23 data sets of tests/data/foreign.

  given_sets.py --driftwise build/release/bin/driftwise [--dir tests/data/foreign] [--only set_01,...]

What must hold: nothing hidden is `adequate` without a name; a single cause is exact, or the finding's set names
it, and nothing false stands with it; both causes of a pair likewise; an effect in no catalogue is `unexplained`
without a name. Subject: the pose coordinate and its motor (x, q1) are one. Exit code 1: one of them does not.
"""
import argparse
import gzip
import json
import os
import subprocess
import sys
import tempfile

MOTOR_OF = {"x": "q1", "y": "q2", "z": "q3"}
ANY_SUBJECT = {"geometry_order", "force_position_coupling"}  # their subject is their term


def names(finding, cause, subject):
    if finding["cause"] != cause:
        return False
    if cause in ANY_SUBJECT or subject is None:
        return True
    alike = {subject, MOTOR_OF.get(subject, subject)}
    alike |= {pose for pose, motor in MOTOR_OF.items() if motor == subject}
    return finding.get("subject") in alike


def has_in_set(finding, cause):
    entries = finding.get("indistinguishable_from") or []
    return any((e if isinstance(e, str) else e.get("cause", "")).split(" ")[0] == cause for e in entries)


def judged(truth, said):
    """Whether it holds, and in which way."""
    findings = said["findings"]
    hidden = truth["hidden"]
    if hidden == ["none"]:
        return said["verdict"] == "adequate" and not findings, "adequate wanted"
    if hidden == ["unexplained"]:
        return said["verdict"] == "unexplained" and not findings, "unexplained wanted"
    left, in_set = list(findings), 0
    for cause, subject in zip(hidden, truth["subject"]):
        match = next((f for f in left if names(f, cause, subject)), None)
        if match is None:
            match = next((f for f in left if has_in_set(f, cause)), None)
            in_set += match is not None
        if match is None:
            return False, f"{cause} {subject} is not there"
        left.remove(match)
    if left:
        return False, "something false with it"
    return True, f"{in_set} in the set" if in_set else "exact"


def main():
    here = os.path.dirname(os.path.abspath(__file__))
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--driftwise", required=True)
    parser.add_argument("--dir", default=os.path.join(here, "../../data/foreign"))
    parser.add_argument("--only", help="these, separated by commas")
    args = parser.parse_args()
    with open(os.path.join(args.dir, "key.json")) as text:
        key = json.load(text)
    wanted = args.only.split(",") if args.only else sorted(key)
    failed = []
    with tempfile.TemporaryDirectory() as folder:
        for name in wanted:
            path = os.path.join(folder, name + ".csv")
            with gzip.open(os.path.join(args.dir, name + ".csv.gz")) as packed, open(path, "wb") as plain:
                plain.write(packed.read())
            done = subprocess.run([args.driftwise, "diagnose", path, "--baseline", key[name]["baseline"], "--json"],
                                  capture_output=True, text=True)
            try:
                said = json.loads(done.stdout)
                holds, how = judged(key[name], said)
                answer = said["verdict"] + " " + ", ".join(
                    f"{f['cause']} {f.get('subject') or ''}".strip() for f in said["findings"])
            except ValueError:
                holds, how, answer = False, done.stderr.strip(), "no answer"
            if not holds:
                failed.append(name)
            hidden = ", ".join(" ".join(filter(None, pair)) for pair in zip(key[name]["hidden"], key[name]["subject"]))
            print(f"{name} {'holds' if holds else 'FAILS'} ({how}): {hidden} -> {answer}", flush=True)
    print(f"{len(wanted) - len(failed)} of {len(wanted)} hold")
    return 1 if failed else 0


if __name__ == "__main__":
    sys.exit(main())
