#!/usr/bin/env python3
"""Sixty hours of cell time at the highest speed that the cell keeps up with: runs one after the other, and what the daemon
needs meanwhile, hour by hour.

sixty_hours.py BIN_DIR SOURCE_DIR [--hours 60] [--kind linear-axis] [--speed 400] [--table FILE]

Judged: memory grows by less than 5 % after the first day (median of the last six hours over that of the six hours after
the first 24), no open file more at the end, each row of each run once, no run that stops, the latency of a target. Exit
code 1: one of these does not hold. Fewer hours than 36 are run, but nothing about growth is judged.
"""
import argparse
import datetime
import json
import os
import pathlib
import socket
import statistics
import sys
import time

from cell import Cell, Trouble, plan_of

TARGETS = 400  # asked at each hour


class Line:
    """The text line for controllers: one question, one answer."""
    def __init__(self, address):
        host, port = address.rsplit(":", 1)
        self.socket = socket.create_connection((host, int(port)), 10)
        self.socket.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
        self.file = self.socket.makefile("rb")

    def ask(self, text):
        self.socket.sendall(text.encode() + b"\n")
        return self.file.readline().decode().strip()

    def latencies_us(self, text):
        found = []
        for _ in range(TARGETS):
            begin = time.perf_counter()
            answer = self.ask(text)
            found.append(1e6 * (time.perf_counter() - begin))
            if not answer.startswith("OK"):
                raise Trouble("a target was refused: " + answer)
        return found


def sample(cell, line, target):
    pid = cell.daemon.pid
    status = dict(one.split(":", 1) for one in pathlib.Path("/proc/%d/status" % pid).read_text().splitlines() if ":" in one)
    latency = sorted(line.latencies_us(target))
    return {"rss_kb": int(status["VmRSS"].split()[0]), "threads": int(status["Threads"]), "files": len(os.listdir("/proc/%d/fd" % pid)),
            "db_kb": cell.database.stat().st_size // 1024, "p50_us": latency[len(latency) // 2], "p99_us": latency[len(latency) * 99 // 100]}


def cell_hours(cell):
    first, last = cell.rows("SELECT min(start_ns), max(start_ns) FROM reading")[0]
    return (last - first) / 3.6e12 if first else 0.0


def measure(cell, hours, kind):
    cell.start()
    runs = [cell.begin(plan_of(kind, 12, 12), "first")]
    stops = cell.end_run(runs[0], 600)
    formula, target = ("q ~ x", "TARGET x_mm=1") if kind == "linear-axis" else ("q ~ x + y + z", "TARGET x_mm=1 y_mm=1 z_mm=1")
    cell.ask("fit", "--run", runs[0], "--model", formula)
    promoted = cell.cli("model", "promote", 1, "--yes")
    if promoted.returncode != 0:
        raise Trouble("promote: " + promoted.stdout + promoted.stderr)
    notice = json.loads((cell.folder / "driftwised.json").read_text())
    line = Line(notice["target_line"])
    samples, next_hour = [], cell_hours(cell) + 1
    while cell_hours(cell) < hours:
        runs.append(cell.begin(plan_of(kind, 60, 20), "hours"))
        while cell.state(runs[-1])[0] not in ("done", "failed", "aborted"):
            state, reason = cell.state(runs[-1])[:2]
            if state == "paused":
                stops.append("paused: " + reason)
                cell.cli("run", "resume", runs[-1], "--yes")
            at = cell_hours(cell)
            if at >= next_hour:
                samples.append({"hour": at, **sample(cell, line, target)})
                print("hour %5.1f  %6d kB of memory, %3d files, database %7d kB, target p50 %4.0f p99 %4.0f us" %
                      (at, samples[-1]["rss_kb"], samples[-1]["files"], samples[-1]["db_kb"], samples[-1]["p50_us"], samples[-1]["p99_us"]), flush=True)
                next_hour = at + 1
            if at >= hours:
                break
            time.sleep(0.5)
        if cell.state(runs[-1])[0] in ("failed", "aborted"):
            raise Trouble("run %d: %s: %s" % (runs[-1], *cell.state(runs[-1])[:2]))
        if cell_hours(cell) >= hours and cell.state(runs[-1])[0] != "done":
            cell.cli("run", "abort", runs[-1])
            cell.wait("aborted", lambda: cell.state(runs[-1])[0] in ("aborted", "done"))
    lost, doubled = cell.judge(runs[0])
    for run in runs[1:]:
        if cell.state(run)[0] == "done":
            more = cell.judge(run)
            lost, doubled = lost + more[0], doubled + more[1]
    return samples, runs, stops, lost, doubled


def middle(samples, what, begin, end):
    return statistics.median(one[what] for one in samples if begin <= one["hour"] < end)


def main():
    words = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    words.add_argument("programs")
    words.add_argument("source")
    words.add_argument("--hours", type=float, default=60)
    words.add_argument("--kind", default="linear-axis", choices=("linear-axis", "micro-nano"))
    words.add_argument("--speed", type=float, default=400)
    words.add_argument("--seed", type=int, default=1)
    words.add_argument("--table")
    given = words.parse_args()
    begun = time.monotonic()
    with Cell(given.programs, given.source, kind=given.kind, speed=given.speed, seed=given.seed) as cell:
        samples, runs, stops, lost, doubled = measure(cell, given.hours, given.kind)
        points, alarms = cell.count("SELECT count(*) FROM planned_point"), cell.rows("SELECT kind, subject FROM alarm")
        hours = cell_hours(cell)
    spent = time.monotonic() - begun
    bad = ["%d rows lost, %d doubled" % (lost, doubled)] if lost or doubled else []
    bad += ["stopped: " + one for one in stops]
    lines = ["# Sixty hours of a cell", "",
             "`tests/faults/campaign/sixty_hours.py` (%s, asked for %g times life), %s: %.1f hours of cell time in %.0f s, %.0f times life; %d runs, %d points." %
             (given.kind, given.speed, datetime.date.today(), hours, spent, 3600 * hours / spent, len(runs), points), "",
             "| | first day (hours 18 to 24) | last six hours | |", "|---|---|---|---|"]
    if samples and samples[-1]["hour"] >= 36:
        end = samples[-1]["hour"] + 0.1
        day, last = ({what: middle(samples, what, *of) for what in ("rss_kb", "files", "threads", "p50_us", "p99_us")} for of in ((24, 30), (end - 6, end)))
        growth = 100 * (last["rss_kb"] / day["rss_kb"] - 1)
        lines[4] = "| median of six hours | hours 24 to 30 | the last six | |"
        lines += ["| memory (resident) | %.1f MB | %.1f MB | %+.1f %% (limit 5 %%) |" % (day["rss_kb"] / 1024, last["rss_kb"] / 1024, growth),
                  "| open files | %d | %d | |" % (day["files"], last["files"]), "| threads | %d | %d | |" % (day["threads"], last["threads"]),
                  "| a target on the text line, p50 | %.0f us | %.0f us | |" % (day["p50_us"], last["p50_us"]),
                  "| p99 of %d | %.0f us | %.0f us | |" % (TARGETS, day["p99_us"], last["p99_us"])]
        bad += ["memory grew by %.1f %% after the first day" % growth] if growth >= 5 else []
        bad += ["%d open files more" % (last["files"] - day["files"])] if last["files"] > day["files"] else []
        bad += ["a target takes %.0f us, after a day %.0f" % (last["p50_us"], day["p50_us"])] if last["p50_us"] > 1.3 * day["p50_us"] else []
    else:
        lines = lines[:4]
    first, final = samples[0], samples[-1]
    lines += ["", "Database: %.2f MB an hour. Alarms: %s." %
              ((final["db_kb"] - first["db_kb"]) / 1024 / max(1e-9, final["hour"] - first["hour"]),
               ", ".join("%s of %s" % one for one in alarms) or "none"), "",
              "What failed: %s." % ("; ".join(bad) or "nothing")]
    text = "\n".join(lines) + "\n"
    print(text)
    if given.table:
        pathlib.Path(given.table).write_text(text)
    return 1 if bad else 0


if __name__ == "__main__":
    sys.exit(main())
