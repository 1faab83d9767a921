#!/usr/bin/env python3
"""The fault campaign: faults by class, counted, with what they cost. Resumable: each trial is a line in OUT/trials.jsonl,
and a trial that was made with these programs is not repeated.

campaign.py BIN_DIR SOURCE_DIR [--out DIR] [--scale 1] [--class NAME ...] [--minutes M] [--table FILE] [--list] [--again]

--scale 0.05 makes a twentieth of each count; --minutes ends the campaign after so long, where it was. The table states
the counts that were reached. Exit code 1: something was lost, doubled, or stopped without a reason.
"""
import argparse
import contextlib
import datetime
import gzip
import hashlib
import json
import math
import os
import pathlib
import random
import resource
import shutil
import socket
import sqlite3
import subprocess
import sys
import tempfile
import time

from cell import Cell, Trouble, plan_of
from wire import KINDS

PER_TRIAL = 10  # kills of one run


# ------------------------------------------------------------------------------------------------------------ intervals
def beta_quantile(share, a, b):
    """Of the beta distribution, by bisection of its incomplete integral (continued fraction)."""
    def cdf(x):
        if x <= 0 or x >= 1:
            return float(x >= 1)
        front = math.exp(math.lgamma(a + b) - math.lgamma(a) - math.lgamma(b) + a * math.log(x) + b * math.log(1 - x))
        if x > (a + 1) / (a + b + 2):
            return 1 - front / b * fraction(b, a, 1 - x)
        return front / a * fraction(a, b, x)

    def fraction(p, q, x):
        c, d = 1.0, 1 - (p + q) * x / (p + 1)
        d = 1 / (d or 1e-300)
        h = d
        for m in range(1, 400):
            for even in (True, False):
                n = (m * (q - m) * x / ((p + 2 * m - 1) * (p + 2 * m)) if even
                     else -(p + m) * (p + q + m) * x / ((p + 2 * m) * (p + 2 * m + 1)))
                d = 1 / ((1 + n * d) or 1e-300)
                c = (1 + n / c) or 1e-300
                h *= d * c
            if abs(d * c - 1) < 1e-12:
                break
        return h
    low, high = 0.0, 1.0
    for _ in range(100):
        middle = (low + high) / 2
        low, high = (middle, high) if cdf(middle) < share else (low, middle)
    return low


def clopper_pearson(k, n):
    """95 % interval of a rate of which k of n were seen."""
    return (0.0 if k == 0 else beta_quantile(0.025, k, n - k + 1), 1.0 if k == n else beta_quantile(0.975, k + 1, n - k))


# --------------------------------------------------------------------------------------------------------------- trials
# Each answers with a dictionary: faults (how many), lost, doubled, and what else there is to tell.
class Campaign:
    def __init__(self, programs, source):
        self.programs, self.source = pathlib.Path(programs).resolve(), pathlib.Path(source).resolve()

    def cell(self, **more):
        return Cell(self.programs, self.source, **more)

    # SIGKILL at random instants of one run. What stood after each kill must stand unchanged at the end.
    def kills(self, kind, seed):
        draw = random.Random(seed)
        with self.cell(kind=kind, speed=100 if kind == "linear-axis" else 200, seed=seed % 1000 + 1) as cell:
            cell.start()
            run = cell.begin(plan_of(kind, 12, 12))
            before, done, lost, doubled = {}, 0, 0, 0
            for _ in range(PER_TRIAL):
                told = self.told_while(cell, run, draw.uniform(0.005, 1.1))
                cell.kill()
                done += 1
                points = cell.points(run)
                lost += max(0, told - sum(map(len, points.values())))
                lost += sum(one not in points.get(row, []) for row, hashes in before.items() for one in hashes)
                before = points
                cell.start()
                if cell.state(run)[0] == "done":
                    break
            explained = cell.end_run(run, 180)
            more = cell.judge(run, before=before)
            return {"faults": done, "lost": lost + more[0], "doubled": doubled + more[1], "explained": explained}

    def told_while(self, cell, run, seconds):
        """The largest number of accepted points that a client was told in this time."""
        watch = subprocess.Popen([str(self.programs / "driftwise"), "run", "watch", str(run), "--json"], cwd=cell.folder,
                                 env=cell.environment, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True)
        time.sleep(seconds)
        watch.terminate()
        told = 0
        for line in watch.communicate(timeout=20)[0].splitlines():
            with contextlib.suppress(ValueError):
                progress = json.loads(line)
                run_now = progress.get("run") or (progress.get("progress") or {}).get("run") or {}
                told = max(told, run_now.get("accepted_count") or 0)
        return told

    def kill_linear_axis(self, seed):
        return self.kills("linear-axis", seed)

    def kill_micro_nano(self, seed):
        return self.kills("micro-nano", seed)

    def kill_in_improvement(self, seed):
        draw = random.Random(seed)
        with self.cell(speed=400, seed=seed % 1000 + 1) as cell:
            cell.start()
            path = cell.folder / "plan.csv"
            path.write_text(plan_of("linear-axis", 6, 8))
            loop = subprocess.Popen([str(self.programs / "driftwise"), "improve", str(path), "--model", "q ~ x", "--max-turns", "2"],
                                    cwd=cell.folder, env=cell.environment, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
            cell.wait("the loop has a run", lambda: cell.count("SELECT count(*) FROM run") > 0)
            time.sleep(draw.uniform(0.01, 6))
            cell.kill()
            loop.wait(60)
            runs = [one[0] for one in cell.rows("SELECT run_id FROM run")]
            before = {run: cell.points(run) for run in runs}
            cell.start()
            lost = doubled = 0
            explained = []
            for run in runs:
                explained += cell.end_run(run)
                more = cell.judge(run, before=before[run])
                lost, doubled = lost + more[0], doubled + more[1]
            states = cell.ask("improve", "list")["improvements"]
            if any(one["state"] not in ("failed", "done") or (one["state"] == "failed" and not one.get("reason")) for one in states):
                raise Trouble("the loop neither ended nor says why: %s" % states)
            return {"faults": 1, "lost": lost, "doubled": doubled, "explained": explained}

    # The copy that a kill leaves is whole or is not offered as one.
    def kill_in_backup(self, seed):
        draw = random.Random(seed)
        with self.cell(speed=200, seed=seed % 1000 + 1) as cell:
            cell.start()
            run = cell.begin(plan_of("linear-axis", 6, 8))
            cell.wait("some points", lambda: cell.state(run)[2] >= 3)
            backup = subprocess.Popen([str(self.programs / "driftwise"), "backup"], cwd=cell.folder, env=cell.environment,
                                      stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True)
            time.sleep(draw.uniform(0.0, 0.25))
            cell.kill()
            backup.wait(60)
            before = cell.points(run)
            told = before and len(before)
            copies = list((cell.folder / "backups").glob("*.db"))
            for copy in copies:
                verified = cell.cli("audit", "verify", "--database", copy)
                if verified.returncode != 0:
                    raise Trouble("a copy that is offered is not whole: %s: %s" % (copy.name, verified.stdout + verified.stderr))
            cell.start()
            explained = cell.end_run(run)
            lost, doubled = cell.judge(run, told=told or 0, before=before)
            return {"faults": 1, "lost": lost, "doubled": doubled, "explained": explained, "copies": len(copies)}

    # An old record, killed while the daemon brings it to the newest layout.
    def kill_in_migration(self, seed):
        draw = random.Random(seed)
        with self.cell(speed=100, seed=1) as cell:
            for name in list(cell.folder.glob("driftwise.sqlite*")):
                name.unlink()
            with contextlib.closing(sqlite3.connect(cell.database)) as record:
                if seed % 2:
                    record.executescript((self.source / "tests/data/databases/version_1_cell.sql").read_text())
                else:
                    record.executescript(gzip.open(self.source / "tests/data/demos/linear-axis.sql.gz", "rt").read())
                tables = [one[0] for one in record.execute("SELECT name FROM sqlite_master WHERE type = 'table' AND name IN "
                                                           "('run', 'point', 'point_value', 'attempt', 'reading', 'model')")]
                rows = {name: record.execute("SELECT count(*) FROM " + name).fetchone()[0] for name in tables}
            old = cell.count("PRAGMA user_version")
            met = 0
            for _ in range(3):
                cell.start(wait=False)
                time.sleep(draw.uniform(0.0, 0.12))
                cell.kill()
                met += cell.count("PRAGMA user_version") == old
            cell.start()
            new = cell.count("PRAGMA user_version")
            if new <= old:
                raise Trouble("the record is still of version %d" % new)
            lost = sum(max(0, count - cell.count("SELECT count(*) FROM " + name)) for name, count in rows.items()
                       if name != "reading")  # raw readings of an old layout live in other tables
            doubled = sum(max(0, cell.count("SELECT count(*) FROM " + name) - count) for name, count in rows.items()
                          if name in ("run", "point", "attempt"))
            if cell.rows("PRAGMA integrity_check") != [("ok",)]:
                raise Trouble("the file is damaged")
            return {"faults": 3, "lost": lost, "doubled": doubled, "before_the_step": met}

    # The computer loses power with the cell: both are gone, the controller has lost its reference.
    def power_cut_of_both(self, seed):
        draw = random.Random(seed)
        with self.cell(speed=100, seed=seed % 1000 + 1, notify=True) as cell:
            cell.start()
            run = cell.begin(plan_of("linear-axis", 5, 8))
            cell.wait("the first point", lambda: cell.state(run)[2] >= 1)
            time.sleep(draw.uniform(0.0, 2.0))
            cell.kill()
            cell.plant.kill()
            cell.plant.wait()
            before = cell.points(run)
            was_over = cell.state(run)[0] == "done"
            time.sleep(draw.uniform(0.1, 1.0))
            cell.plant = cell.start_plant(["--cell", cell.folder / "cell.toml"])
            cell.start()
            explained = []
            if not was_over:
                # Nobody has said that the robot may move: the run must wait and say so.
                cell.wait("the run waits for a person", lambda: cell.state(run)[0] in ("paused", "waiting", "done"), 60)
                if cell.state(run)[0] == "done":
                    raise Trouble("the run went on by itself after the power had been away")
                explained = ["waits: " + cell.state(run)[1]]
                cell.cli("run", "resume", run, "--yes")
            explained += cell.end_run(run)
            lost, doubled = cell.judge(run, told=len(before), before=before)
            return {"faults": 1, "lost": lost, "doubled": doubled, "explained": explained, **cell.alarms()}

    # One device's line misbehaves at a random step, several times in one run.
    def device(self, device, kind, seed):
        draw = random.Random(seed)
        with self.cell(speed=100, seed=seed % 1000 + 1, proxies=True, notify=True) as cell:
            cell.start()
            run = cell.begin(plan_of("linear-axis", 14, 10))
            cell.wait("some points", lambda: cell.state(run)[2] >= 2)
            faults, explained, met = 0, [], 0
            line = cell.wires.lines[device]
            while faults < 6 and cell.state(run)[0] != "done":
                time.sleep(draw.uniform(0.05, 0.6))
                cell.wires.fault(device, kind, draw.uniform(0.2, 2.0))
                faults += 1
                cell.wait("the fault is over", lambda: not line.active(), 30)
                met += line.touched > 0
                told = cell.state(run)[2]
                until = time.monotonic() + 90
                while cell.state(run)[2] <= told and cell.state(run)[0] != "done":
                    state, reason = cell.state(run)[:2]
                    if state in ("paused", "failed", "aborted") or (state == "waiting" and time.monotonic() > until - 80):
                        if not reason:
                            raise Trouble("the run is %s without a reason" % state)
                        if cell.cli("run", "resume", run, "--yes").returncode == 0:
                            explained.append("%s: %s" % (state, reason))
                    if state in ("failed", "aborted"):
                        break
                    if time.monotonic() > until:
                        raise Trouble("90 s after the fault the run is %s: %s" % (state, reason))
                    time.sleep(0.05)
                if cell.state(run)[0] in ("failed", "aborted"):
                    break
            if cell.state(run)[0] not in ("failed", "aborted", "done"):
                explained += cell.end_run(run, 180)
            lost, doubled = cell.judge(run)
            return {"faults": faults, "met": met, "lost": lost, "doubled": doubled, "explained": explained, **cell.alarms()}

    # A lie of the emulator in well-formed answers: an incident is told once, the run waits or goes on.
    def lie(self, device, seed):
        draw = random.Random(seed)
        lies = {"axis": ("jump 0.01", "constant"), "laser-x": ("jump 100000", "constant", "scale 1.01"),
                "scanner": ("jump 100", "constant"), "support": ("jump 3", "constant")}
        with self.cell(speed=100, seed=seed % 1000 + 1, notify=True) as cell:
            cell.start()
            run = cell.begin(plan_of("linear-axis", 8, 10))
            cell.wait("some points", lambda: cell.state(run)[2] >= 3)
            time.sleep(draw.uniform(0.0, 1.0))
            said = cell.tell("fault lie %s %s" % (device, draw.choice(lies[device])))
            if not said.startswith("OK"):
                raise Trouble("the emulator refused the lie: " + said)
            time.sleep(draw.uniform(1.0, 4.0))
            cell.tell("fault clear " + device)
            explained = cell.end_run(run, 180)
            lost, doubled = cell.judge(run)
            return {"faults": 1, "lost": lost, "doubled": doubled, "explained": explained, **cell.alarms()}

    # After a stop the axis stands, whatever its line does, until a person resumes.
    def stop(self, seed, with_fault=False):
        draw = random.Random(seed)
        with self.cell(speed=20, seed=seed % 1000 + 1, proxies=True) as cell:
            cell.start()
            run = cell.begin(plan_of("linear-axis", 10, 10))
            cell.wait("it moves", lambda: cell.state(run)[2] >= 1, 90)
            stops = went_on = 0
            refused = []
            for _ in range(6):
                time.sleep(draw.uniform(0.0, 0.6))
                if with_fault:
                    cell.wires.fault("axis", draw.choice(("drop", "freeze", "slow")), draw.uniform(0.2, 1.5))
                cell.cli("stop")
                stops += 1
                cell.wait("the run is paused", lambda: cell.state(run)[0] == "paused", 60)
                first = json.loads(cell.tell("truth?").removeprefix("OK ").strip())
                time.sleep(0.25)
                second = json.loads(cell.tell("truth?").removeprefix("OK ").strip())
                went_on += abs(first["q_scale_nm"] - second["q_scale_nm"]) > 1000  # an axis at rest holds within 35 nm
                # While the stop is pending, because the controller cannot be asked, a resume is refused: that is right.
                answers = []
                until = time.monotonic() + 30
                while (done := cell.cli("run", "resume", run, "--yes")).returncode != 0:
                    answers.append(done.stderr.strip())
                    if time.monotonic() > until:
                        raise Trouble("resume is refused: " + answers[-1])
                    time.sleep(0.2)
                refused += answers[:1]
                time.sleep(0.3)
            cell.cli("run", "abort", run)
            cell.wait("aborted", lambda: cell.state(run)[0] == "aborted")
            lost, doubled = cell.judge(run)
            return {"faults": stops, "lost": lost, "doubled": doubled, "moved_on": went_on, "explained": refused}

    def stop_and_line(self, seed):
        return self.stop(seed, True)

    # The wall clock of the daemon alone is set to and fro by libfaketime; the machine's is not touched.
    def clock(self, seed):
        draw = random.Random(seed)
        library = next(iter(pathlib.Path("/usr/lib").glob("*/faketime/libfaketimeMT.so.1")), None)
        timers = self.programs / "libdriftwise_test_timers_of_the_kernel.so"
        if not library or not timers.exists():
            return None
        with tempfile.NamedTemporaryFile("w", suffix=".faketime") as rate:
            def set_clock(text):
                pathlib.Path(rate.name).write_text(text + "\n")
            set_clock("+0")
            with self.cell(speed=100, seed=seed % 1000 + 1) as cell:
                # Without the first library timers may never end, without NO_FAKE_STAT the daemon's own files seem to be changed
                # by somebody: libfaketime moves both by the offset of the clock.
                cell.environment.update({"LD_PRELOAD": "%s:%s" % (timers, library), "NO_FAKE_STAT": "1",
                                         "FAKETIME_TIMESTAMP_FILE": rate.name, "FAKETIME_CACHE_DURATION": "1",
                                         "FAKETIME_DONT_FAKE_MONOTONIC": "1", "DONT_FAKE_MONOTONIC": "1"})
                cell.start()
                for name in ("LD_PRELOAD", "FAKETIME_TIMESTAMP_FILE"):
                    cell.environment.pop(name)
                run = cell.begin(plan_of("linear-axis", 16, 8))
                cell.wait("some points", lambda: cell.state(run)[2] >= 2)
                steps = 0
                while steps < 6 and cell.state(run)[0] != "done":
                    # An hour and a day to and fro, a leap second repeated, a second smeared.
                    set_clock(draw.choice(("+3600", "-3600", "+86400", "-86400", "-1", "+0", "+0 x1.00001", "+0 x0.99999")))
                    steps += 1
                    time.sleep(draw.uniform(1.1, 2.0))
                explained = cell.end_run(run, 240)
                lost, doubled = cell.judge(run)
                order = cell.rows("SELECT measured_monotonic_ns FROM point WHERE run_id = %d ORDER BY point_id" % run)
                doubled += sum(a >= b for a, b in zip(order, order[1:]))  # an instant is never had twice
                return {"faults": steps, "lost": lost, "doubled": doubled, "explained": explained}

    # 200 watchers, half of which never read, and up to 10 000 connections that say nothing.
    def clients(self, seed):
        draw = random.Random(seed)
        soft, hard = resource.getrlimit(resource.RLIMIT_NOFILE)
        resource.setrlimit(resource.RLIMIT_NOFILE, (hard, hard))
        connections = []
        try:
            with self.cell(speed=100, seed=seed % 1000 + 1) as cell:
                cell.start()
                notice = json.loads((cell.folder / "driftwised.json").read_text())
                host, port = notice["web"].split("//")[-1].rstrip("/").rsplit(":", 1)
                run = cell.begin(plan_of("linear-axis", 6, 10))
                watchers = refused = 0
                for number in range(200):
                    peer = socket.create_connection((host, int(port)), 10)
                    peer.sendall(("POST /driftwise.v1.WatchService/Watch HTTP/1.1\r\nHost: %s:%s\r\nOrigin: http://%s:%s\r\n"
                                  "Content-Type: application/grpc-web+proto\r\nContent-Length: 5\r\n\r\n" % (host, port, host, port)).encode()
                                 + b"\0\0\0\0\0")
                    if number % 2:
                        peer.settimeout(10)
                        with contextlib.suppress(OSError):
                            answer = peer.recv(200)
                            watchers += b" 200 " in answer
                            refused += b" 200 " not in answer
                    connections.append(peer)
                opened = 0
                for _ in range(10_000):
                    try:
                        connections.append(socket.create_connection((host, int(port)), 2))
                        opened += 1
                    except OSError:
                        break
                begun = time.monotonic()
                answered = cell.cli("status").returncode == 0
                status_s = time.monotonic() - begun
                stopped = cell.cli("stop").returncode == 0
                cell.wait("the run is paused", lambda: cell.state(run)[0] in ("paused", "done"), 60)
                if not (answered and stopped):
                    raise Trouble("status answered: %s, stop: %s" % (answered, stopped))
                cell.cli("run", "resume", run, "--yes")
                explained = cell.end_run(run, 240)
                lost, doubled = cell.judge(run)
                return {"faults": 1, "lost": lost, "doubled": doubled, "explained": explained, "connections": opened,
                        "watchers_that_read": watchers, "refused": refused, "status_s": round(status_s, 2), "draw": draw.random()}
        finally:
            for one in connections:
                one.close()
            resource.setrlimit(resource.RLIMIT_NOFILE, (soft, hard))

    # A page of the record is overwritten: it is found, named, and the rest is readable.
    def page(self, seed):
        draw = random.Random(seed)
        with tempfile.TemporaryDirectory(prefix="driftwise-page-") as folder:
            path = pathlib.Path(folder) / "record.sqlite"
            shutil.copy(self.finished_record(), path)
            size = path.stat().st_size
            with contextlib.closing(sqlite3.connect(path)) as record:
                protected = {one[0] for one in record.execute("SELECT DISTINCT tbl_name FROM sqlite_master WHERE tbl_name IN "
                                                              "('point', 'point_value', 'attempt', 'run', 'event', 'reading', 'datum', 'model')")}
                owner = dict(record.execute("SELECT pageno, name FROM dbstat")) if has_dbstat(record) else {}
                tables = [one[0] for one in record.execute("SELECT name FROM sqlite_master WHERE type = 'table' AND name NOT LIKE 'sqlite_%'")]
                whole = {name: record.execute("SELECT count(*) FROM \"%s\"" % name).fetchone()[0] for name in tables}
            number = draw.randrange(2, size // 4096)
            with open(path, "r+b") as file:
                file.seek((number - 1) * 4096)
                file.write(draw.randbytes(4096))
            done = subprocess.run([str(self.programs / "driftwise"), "audit", "verify", "--database", str(path)], capture_output=True,
                                  text=True, timeout=120)
            said = done.stdout + done.stderr
            readable = 0
            for name in tables:
                with contextlib.suppress(sqlite3.Error), contextlib.closing(sqlite3.connect(path)) as record:
                    readable += len(record.execute("SELECT * FROM \"%s\"" % name).fetchall()) == whole[name]
            table = owner.get(number, "")
            # What the daemon asks at idle, and what the chain says.
            try:
                with contextlib.closing(sqlite3.connect(path)) as record:
                    sound = record.execute("PRAGMA quick_check(1)").fetchone() == ("ok",)
            except sqlite3.Error:
                sound = False
            found = done.returncode != 0 or not sound
            if table in protected and not found:
                raise Trouble("a page of %s was overwritten and nothing says so" % table)
            return {"faults": 1, "lost": 0, "doubled": 0, "found": found, "of": table, "protected": table in protected,
                    "said": said.strip()[-160:], "readable": readable, "tables": len(tables)}

    def finished_record(self):
        kept = pathlib.Path(tempfile.gettempdir()) / ("driftwise-campaign-record-%d.sqlite" % os.getpid())
        if not kept.exists():
            with self.cell(speed=300) as cell:
                cell.start()
                cell.end_run(cell.begin(plan_of("linear-axis", 10, 10)))
                cell.daemon.terminate()
                cell.daemon.wait(30)
                shutil.copy(cell.database, kept)
        return kept

    # Counts of a test program: what it records as "faults".
    def gtest(self, program, filter_, environment=None):
        with tempfile.NamedTemporaryFile(suffix=".json") as report:
            done = subprocess.run([str(self.programs / program), "--gtest_filter=" + filter_, "--gtest_output=json:" + report.name],
                                  capture_output=True, text=True, env={**os.environ, **(environment or {})}, timeout=3600)
            tests = [test for suite in json.load(open(report.name))["testsuites"] for test in suite["testsuite"]]
        if done.returncode != 0:
            raise Trouble((done.stdout + done.stderr)[-400:])
        return {"faults": sum(int(test.get("faults", 1)) for test in tests), "lost": 0, "doubled": 0}


def has_dbstat(record):
    try:
        record.execute("SELECT pageno FROM dbstat LIMIT 1")
        return True
    except sqlite3.Error:
        return False


def classes(campaign):
    """name: (what, trials, function of a seed)."""
    c = campaign
    table = {
        "kill linear-axis": ("SIGKILL at random instants of a run, %d to a run" % PER_TRIAL, 25, c.kill_linear_axis),
        "kill micro-nano": ("the same, three axes at 200 times life", 25, c.kill_micro_nano),
        "kill in an improvement": ("SIGKILL inside an improvement loop", 40, c.kill_in_improvement),
        "kill in a backup": ("SIGKILL while a copy is made", 40, c.kill_in_backup),
        "kill in a migration": ("SIGKILL while an old record (version 1 or 6) is brought to the newest layout, 3 to a record", 30, c.kill_in_migration),
        "power cut, store": ("power fails under the store, any sectors arrive", 10,
                             lambda seed: c.gtest("faults_storage", "PowerCut.LosesNothingAcknowledgedWhateverSectorsArrived",
                                                  {"DRIFTWISE_POWER_CUTS": "200", "DRIFTWISE_POWER_CUT_SEED": str(seed)})),
        "power cut, each change": ("power fails at every third and seventh change", 1,
                                   lambda seed: c.gtest("faults_storage", "PowerCut.LosesNothingAcknowledgedWhen*")),
        "power cut, cell": ("power fails under recorder, engine and serving", 1, lambda seed: c.gtest("faults_cell_power_cut", "*")),
        "disk full": ("full disk or failing write at each change of a commit, a checkpoint, an opening", 1,
                      lambda seed: c.gtest("faults_storage", "*FailingDisk*/Full:*FailingDisk*/WriteError")),
        "fsync fails": ("failing fsync at the same places", 1, lambda seed: c.gtest("faults_storage", "*FailingDisk*/SyncError")),
        "page": ("one page of the record overwritten: found, the rest readable", 100, c.page),
        "power cut of both": ("SIGKILL to daemon and cell at once; the controller loses its reference", 30, c.power_cut_of_both),
    }
    for device in ("axis", "laser-x", "scanner", "support"):
        for kind in KINDS:
            table["%s: %s" % (device, kind)] = (
                {"drop": "connections cut and refused", "freeze": "no answer comes", "slow": "every answer 0.15 s late",
                 "late": "one answer 4 s late", "other": "answers of other questions", "garble": "one byte of each answer changed"}[kind],
                5, lambda seed, device=device, kind=kind: c.device(device, kind, seed))
        table["%s: lie" % device] = ("well-formed answers that are false", 10, lambda seed, device=device: c.lie(device, seed))
    table["stop"] = ("a person stops the axes in a run", 10, c.stop)
    table["stop, line away"] = ("the same while the controller's line drops, freezes or is slow", 10, c.stop_and_line)
    table["clock"] = ("the daemon's wall clock set by libfaketime: hours, days, a leap second, a smeared one", 10, c.clock)
    table["clients"] = ("200 watchers, half of which never read, and 10 000 connections", 3, c.clients)
    return table


# -------------------------------------------------------------------------------------------------------------- the rest
def version_of(programs):
    digest = hashlib.sha256()
    for name in ("driftwised", "driftwise-cellsim"):
        digest.update((pathlib.Path(programs) / name).read_bytes())
    return digest.hexdigest()[:12]


def read_trials(path):
    if not path.exists():
        return []
    return [json.loads(line) for line in path.read_text().splitlines() if line.strip()]


def table_of(table, trials, head):
    lines = ["# The fault campaign", "", *head, "",
             "| class | what | trials | faults | lost | doubled | stops without a reason | rate of these, 95 % | alarms told, twice, not | waits that said why |",
             "|---|---|---|---|---|---|---|---|---|---|"]
    for name, (what, _, _) in table.items():
        of = [one for one in trials if one["class"] == name and not one.get("skipped")]
        if not of:
            lines.append("| %s | %s | 0 | | | | | | | |" % (name, what))
            continue
        good = [one for one in of if "failure" not in one]
        faults = sum(one["faults"] for one in good) + len(of) - len(good)
        lost, doubled = sum(one["lost"] for one in good), sum(one["doubled"] for one in good)
        bad = len(of) - len(good) + sum(one.get("moved_on", 0) for one in good)
        low, high = clopper_pearson(min(lost + doubled + bad, faults), faults)
        alarms = "%d, %d, %d" % tuple(sum(one.get(what, 0) for one in good) for what in ("incidents", "told_twice", "untold"))
        said = sum(len(one.get("explained", [])) for one in good)
        lines.append("| %s | %s | %d | %d | %d | %d | %d | %.2f to %.2f %% | %s | %d |" %
                     (name, what, len(of), faults, lost, doubled, bad, 100 * low, 100 * high,
                      alarms if any("told_twice" in one for one in good) else "", said))
    pages = [one for one in trials if one["class"] == "page" and "found" in one]
    if pages:
        lines += ["", "Pages: %d overwritten, %d found by `driftwise audit verify` or by the check of pages; on average %.1f of %d tables were read whole afterwards. "
                      "Not found, of what is derived or holds no row: %s." % (
                          len(pages), sum(one["found"] for one in pages), sum(one["readable"] for one in pages) / len(pages), pages[0]["tables"],
                          ", ".join(sorted({one["of"] or "a free page" for one in pages if not one["found"]})) or "none")]
    crowd = [one for one in trials if one["class"] == "clients" and "connections" in one]
    if crowd:
        lines += ["", "Clients: connections opened %s; `driftwise status` meanwhile in %s s." % (
            ", ".join(str(one["connections"]) for one in crowd), ", ".join(str(one["status_s"]) for one in crowd))]
    failures = [one for one in trials if "failure" in one]
    if failures:
        lines += ["", "What failed:", ""]
        lines += ["- %s, seed %d: %s" % (one["class"], one["seed"], one["failure"].replace("\n", " ")[:300]) for one in failures]
    return "\n".join(lines) + "\n"


def main():
    words = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    words.add_argument("programs")
    words.add_argument("source")
    words.add_argument("--out", default="out/faults")
    words.add_argument("--scale", type=float, default=1)
    words.add_argument("--class", dest="chosen", action="append")
    words.add_argument("--minutes", type=float, default=1e9)
    words.add_argument("--table")
    words.add_argument("--seed", type=int, default=1000)
    words.add_argument("--commit", help="of the programs; else that of SOURCE")
    words.add_argument("--list", action="store_true")
    words.add_argument("--again", action="store_true")
    given = words.parse_args()
    campaign = Campaign(given.programs, given.source)
    table = classes(campaign)
    for name in ("driftwised", "driftwise", "driftwise-cellsim"):
        if not (campaign.programs / name).exists():
            sys.exit("no program %s in %s" % (name, campaign.programs))
    if given.list:
        for name, (what, count, _) in table.items():
            print("%-24s %4d  %s" % (name, count, what))
        return 0
    out = pathlib.Path(given.out)
    out.mkdir(parents=True, exist_ok=True)
    record, version = out / "trials.jsonl", version_of(given.programs)
    if given.again:
        record.unlink(missing_ok=True)
    done = {(one["class"], one["seed"]) for one in read_trials(record) if one["programs"] == version}
    end = time.monotonic() + 60 * given.minutes
    # One trial of each class after the other: a campaign that ends early has some of everything.
    wanted = [(name, number) for name, (_, count, _) in table.items() if not given.chosen or name in given.chosen
              for number in range(max(1, math.ceil(count * given.scale)))]
    share = {name: max(1, math.ceil(count * given.scale)) for name, (_, count, _) in table.items()}
    wanted.sort(key=lambda one: (one[1] / share[one[0]], one[0]))
    for name, number in wanted:
        seed = given.seed + number
        if (name, seed) in done:
            continue
        if time.monotonic() > end:
            print("time is up: the next call goes on here")
            break
        begun = time.monotonic()
        try:
            result = table[name][2](seed) or {"skipped": True}
        except (Trouble, subprocess.TimeoutExpired, sqlite3.Error, OSError, KeyError, ValueError) as error:
            result = {"failure": "%s: %s" % (type(error).__name__, error)}
        result.update({"class": name, "seed": seed, "programs": version, "s": round(time.monotonic() - begun, 1)})
        with open(record, "a") as file:
            file.write(json.dumps(result) + "\n")
        short = result.get("failure") or ", ".join("%s %s" % (key, result[key]) for key in ("faults", "lost", "doubled") if key in result)
        print("%-24s seed %d  %6.1f s  %s" % (name, seed, result["s"], short[:200]), flush=True)
    trials = [one for one in read_trials(record) if one["programs"] == version]
    commit = given.commit or subprocess.run(["git", "-C", given.source, "rev-parse", "--short", "HEAD"], capture_output=True, text=True).stdout.strip()
    head = ["`tests/faults/campaign/campaign.py BIN SOURCE` (a part of `deploy/nightly.sh`), %s, commit %s, %d cores. A class states the "
            "trials and faults that were made. Lost: a point that was on the disk or told to a client, and is gone or changed; a row that a run "
            "that is done lacks. Doubled: a row with two points. Clopper-Pearson interval of lost, doubled and unexplained per fault." %
            (datetime.date.today().isoformat(), commit or "of no repository", os.cpu_count())]
    text = table_of(table, trials, head)
    (out / "table.md").write_text(text)
    if given.table:
        pathlib.Path(given.table).write_text(text)
    bad = [one for one in trials if "failure" in one or one.get("lost") or one.get("doubled") or one.get("moved_on") or one.get("told_twice")
           or one.get("untold")]
    print("%d trials, %d of them with something lost, doubled, told twice or unexplained; the table: %s" % (len(trials), len(bad), out / "table.md"))
    return 1 if bad else 0


if __name__ == "__main__":
    sys.exit(main())
