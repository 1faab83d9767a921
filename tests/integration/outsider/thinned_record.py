#!/usr/bin/python3
"""Thinning of a cell at work: raw readings of the environment become rows of an interval while it measures on, an earlier
head stays on the chain, both checkers say "thinned", and a thinned stretch that is altered is found.

Usage: thinned_record.py BIN SOURCE
"""
import sqlite3
import sys

from cell import SOURCE, Cell, check, run, until


def main():
    with Cell(access=False) as cell:
        def count(text):
            with sqlite3.connect(f"file:{cell.database()}?mode=ro", uri=True) as database:
                return database.execute(text).fetchone()[0]

        plan = cell.path("plan.csv")
        with open(plan, "w", encoding="ascii") as file:
            file.write("q1_mm\n0\n0.1\n")
        number = cell.ask("run", "start", plan)["id"]
        cell.cli("run", "watch", str(number), "--timeout", "100")
        points = count("SELECT count(*) FROM planned_point")
        with_attempt = count("SELECT count(*) FROM reading WHERE attempt_id IS NOT NULL")
        check(points == 2, "a run of two points")
        # Some hours of cell time beside them, at speed 100.
        newest = "(SELECT max(start_ns) - min(start_ns) FROM reading) / 1000000000"
        until("two and a half hours of readings", lambda: count("SELECT " + newest) > 9000, 300)
        head = cell.cli("audit", "head").stdout.strip()
        before = count("SELECT strftime('%Y-%m-%dT%H:%M:%SZ', (max(start_ns) / 1000000000) - 3700, 'unixepoch') FROM reading")
        too_new = count("SELECT strftime('%Y-%m-%dT%H:%M:%SZ', (max(start_ns) / 1000000000) + 60, 'unixepoch') FROM reading")
        done = cell.cli("thin", "--before", too_new, "--yes")
        check(done.returncode == 3 and "at least an hour ago" in done.stderr, "the last hour stays: " + done.stderr.strip())
        check(cell.cli("thin", "--before", before).returncode == 2, "a script says --yes")
        raw = count("SELECT count(*) FROM reading")
        thinned = cell.ask("thin", "--before", before, "--reducer", "mean", "--every", "2min", "--yes")
        removed, rows = int(thinned["reading_count"]), int(thinned["interval_count"])
        check(0 < rows < removed / 2, f"{removed} readings of {raw} became {rows} rows")
        check(count("SELECT count(*) FROM planned_point") == points, "points stay")
        check(count("SELECT count(*) FROM reading WHERE attempt_id IS NOT NULL") == with_attempt, "and what they rest on")
        acts = cell.ask("audit", "list")["acts"]
        act = next(one for one in acts if one["what"] == "readings.thinned")
        check(str(removed) in act["before"] and "mean every 120 s" in act["after"], "the act is in the audit")
        for words in ((), ("--head", head)):
            said = cell.cli("audit", "verify", *words)
            check(said.returncode == 0 and f"{removed} readings of the environment were thinned" in said.stdout and
                  "mean every 120 s, hash " in said.stdout, "verify says thinned, not broken " + " ".join(words)[:20])
        check(int(cell.ask("thin", "--before", before, "--every", "2min", "--yes")["reading_count"]) == 0,
              "what is thinned is not thinned again")
        cell.stop()
        code, said = cell.verify("--head", head)
        check(code == 0 and "thinned: " in said, "without the daemon as well")
        other = run("/usr/bin/python3", SOURCE + "/clients/examples/python/check_chain.py", cell.database())
        check(other.returncode == 0 and "thinned: " in other.stdout and " by " in other.stdout, "the checker of another hand agrees")
        # The same by the cell file, once a day of cell time; the first time at the start.
        with open(cell.path("cell.toml"), "a", encoding="utf-8") as file:
            file.write('\n[thinning]\nafter_days = 0.01\nevery_s = 300\nreducer = "max"\n')
        cell.start()
        until("a thinning by the cell file", lambda: count("SELECT count(*) FROM thinning WHERE proof = 'cell file'") > 0)
        until("its event", lambda: count("SELECT count(*) FROM event WHERE what = 'readings.thinned' AND who = 'daemon'") > 0)
        cell.stop()
        code, said = cell.verify("--head", head)
        check(code == 0 and "by daemon at " in said and "max every 300 s" in said, "by the cell file too: " + said[-200:].strip())
        cell.sql("UPDATE thinned_value SET value = value + 1e-6 WHERE value IS NOT NULL AND start_ns = "
                 "(SELECT max(start_ns) FROM thinned_value)")
        code, said = cell.verify()
        check(code == 1 and "thinned_value with thinning_id" in said, "a thinned value that was altered is found")
        other = run("/usr/bin/python3", SOURCE + "/clients/examples/python/check_chain.py", cell.database())
        check(other.returncode == 1 and "thinning with key" in other.stdout, "by the checker of another hand too")
    return 0


if __name__ == "__main__":
    sys.exit(main())
