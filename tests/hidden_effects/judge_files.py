#!/usr/bin/env python3
"""Diagnoses data sets that come with a key and prints what was found beside what is hidden.

    judge_files.py PROGRAM FOLDER [NAME ...]

PROGRAM: the release build of driftwise. FOLDER: <name>.csv.gz and key.json (per name: baseline,
hidden, subject, chi2). The key chooses nothing: it is read for the baseline formula and printed.
Columns: name, hidden, verdict, findings with their indistinguishable sets, rms-free U90 held out
before and after per output, processor seconds. Last: counts.
"""
import gzip
import json
import os
import resource
import subprocess
import sys
import tempfile


def diagnosed(program, csv, baseline):
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    done = subprocess.run([program, "diagnose", csv, "--baseline", baseline, "--json"],
                          capture_output=True, text=True, check=False)
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    seconds = after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime
    return (json.loads(done.stdout) if done.returncode in (0, 1) else None), seconds, done.stderr


def judged(hidden, found):
    """'right' (adequate, exact, unexplained), 'set' (the hidden one is in a reported set), 'wrong'."""
    names = [one["cause"] for one in found["findings"]]
    if hidden in (["none"], ["unexplained"]):
        wanted = "adequate" if hidden == ["none"] else "unexplained"
        return "right" if found["verdict"] == wanted and not names else "wrong"
    if sorted(names) == sorted(hidden):
        return "right"
    missing = [one for one in hidden if one not in names]
    for one in found["findings"]:
        if one["cause"] in hidden:
            continue
        also = [rival.split()[0] for rival in one.get("indistinguishable_from", [])]
        meant = [name for name in missing if name in also]
        if not meant:
            return "wrong"
        missing.remove(meant[0])
    return "set" if not missing else "wrong"


def main():
    program, folder, only = sys.argv[1], sys.argv[2], sys.argv[3:]
    with open(os.path.join(folder, "key.json"), encoding="utf-8") as file:
        key = json.load(file)
    counts = {}
    for name, truth in sorted(key.items()):
        if only and name not in only:
            continue
        with gzip.open(os.path.join(folder, name + ".csv.gz")) as packed, \
                tempfile.NamedTemporaryFile(suffix=".csv") as csv:
            csv.write(packed.read())
            csv.flush()
            found, seconds, trouble = diagnosed(program, csv.name, truth["baseline"])
        hidden = truth["hidden"]
        group = truth["robot"] + " " + (hidden[0] if hidden[0] in ("none", "unexplained")
                                        else "single" if len(hidden) == 1 else "pair")
        if found is None:
            print(name, group, "refused:", trouble.strip())
            counts.setdefault(group, []).append("wrong")
            continue
        verdict = judged(hidden, found)
        counts.setdefault(group, []).append(verdict)
        names = "; ".join(
            f"{one['cause']} {one['subject']}".strip() +
            (" {" + ", ".join(one["indistinguishable_from"]) + "}"
             if one.get("indistinguishable_from") else "") for one in found["findings"])
        u90 = ", ".join(
            f"{before.get('u90_validation_nm', 0):.3g} -> "
            f"{found['extended']['outputs'][output].get('u90_validation_nm', 0):.3g}"
            for output, before in found["baseline"]["outputs"].items())
        print(f"{name}  hidden: {' + '.join(hidden)} (chi2 {truth['chi2']:.0f})  "
              f"{found['verdict']}: {names or '-'}  [{verdict}]  U90 {u90}  {seconds:.1f} s",
              flush=True)
    for group, outcomes in sorted(counts.items()):
        print(f"{group}: {outcomes.count('right')} right, {outcomes.count('set')} in a set, "
              f"{outcomes.count('wrong')} wrong of {len(outcomes)}")


if __name__ == "__main__":
    main()
