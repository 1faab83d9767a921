"""A cell for the fault campaign: driftwise-cellsim and driftwised as processes, a receiver of alarms, proxies on the
devices' lines; and the judge, which reads the record with sqlite3 alone."""
import collections
import contextlib
import hashlib
import http.server
import json
import os
import pathlib
import signal
import socket
import sqlite3
import subprocess
import tempfile
import threading
import time

from wire import Wires


class Trouble(Exception):
    """The campaign cannot go on with this cell: counted as an unexplained stop."""


class Receiver:
    """An alarm receiver outside the daemon: how often each beginning of an alarm was told."""

    def __init__(self):
        self.told, outer = collections.Counter(), self

        class Handler(http.server.BaseHTTPRequestHandler):
            def do_POST(self):
                body = self.rfile.read(int(self.headers.get("Content-Length", 0)))
                for alert in json.loads(body or b"{}").get("alerts", []):
                    if alert["status"] == "firing":
                        labels = alert["labels"]
                        outer.told[(labels["alertname"], labels.get("subject", ""), alert["startsAt"])] += 1
                self.send_response(200)
                self.end_headers()

            def log_message(self, *unused):
                pass

        self.server = http.server.ThreadingHTTPServer(("127.0.0.1", 0), Handler)
        self.port = self.server.server_address[1]
        threading.Thread(target=self.server.serve_forever, daemon=True).start()

    def close(self):
        self.server.shutdown()
        self.server.server_close()


class Cell:
    def __init__(self, programs, source, kind="linear-axis", speed=100, seed=1, proxies=False, environment=None, notify=False, plant_words=()):
        self.programs, self.kind, self.speed, self.seed = pathlib.Path(programs).resolve(), kind, speed, seed
        self.scratch = tempfile.TemporaryDirectory(prefix="driftwise-campaign-", dir="/dev/shm" if os.path.isdir("/dev/shm") else None)
        self.folder = pathlib.Path(self.scratch.name)
        self.source = pathlib.Path(source).resolve() / "deploy" / "cells" / kind
        self.environment = {**os.environ, "NO_COLOR": "1", **(environment or {})}
        self.log = open(self.folder / "log", "ab")
        self.daemon = None
        self.plant = self.start_plant(["--cell", self.source / "cell.toml", "--instantiate", self.folder, "--speed", speed, *plant_words])
        self.receiver = Receiver() if notify else None
        self.wires = None
        text = (self.folder / "cell.toml").read_text()
        if proxies:
            devices = {name: address for name, address in self.ready.items() if name != "control" and ":" in str(address)}
            self.wires = Wires(devices, seed)
            for name, address in devices.items():
                text = text.replace('"%s"' % address, '"127.0.0.1:%d"' % self.wires.lines[name].port)
        if notify:
            text += '\n[[notify]]\nname = "campaign"\nwebhook = "http://127.0.0.1:%d/"\ngroup_s = 0\nrepeat_h = 0\n' % self.receiver.port
        (self.folder / "cell.toml").write_text(text)

    def start_plant(self, words):
        plant = subprocess.Popen([str(word) for word in [self.programs / "driftwise-cellsim", "--plant", self.source / "plant.toml",
                                                         "--seed", self.seed, *words]],
                                 stdout=subprocess.PIPE, stderr=self.log, text=True, cwd=self.folder, env=self.environment)
        line = plant.stdout.readline()
        if not line.startswith("READY "):
            raise Trouble("driftwise-cellsim did not start: " + line)
        self.ready = json.loads(line[6:])
        return plant

    @property
    def database(self):
        return self.folder / "driftwise.sqlite"

    def start(self, wait=True):
        notice = self.folder / "driftwised.json"
        with contextlib.suppress(FileNotFoundError):
            notice.unlink()
        self.daemon = subprocess.Popen([str(self.programs / "driftwised"), "--cell", str(self.folder / "cell.toml")],
                                       stdout=self.log, stderr=self.log, cwd=self.folder, env=self.environment)
        if wait:
            self.wait("the daemon answers", lambda: notice.exists() or self.daemon.poll() is not None, 60)
            if self.daemon.poll() is not None:
                raise Trouble("driftwised ended with %d: %s" % (self.daemon.returncode, self.tail()))

    def kill(self):
        self.daemon.send_signal(signal.SIGKILL)
        self.daemon.wait()

    def tail(self):
        self.log.flush()
        return (self.folder / "log").read_text(errors="replace")[-1500:]

    def wait(self, what, condition, seconds=60):
        end = time.monotonic() + seconds
        while not condition():
            if time.monotonic() > end:
                raise Trouble("in vain waited for: " + what)
            time.sleep(0.03)

    def cli(self, *words, seconds=60):
        return subprocess.run([str(self.programs / "driftwise"), *map(str, words)], cwd=self.folder, env=self.environment,
                              capture_output=True, text=True, timeout=seconds)

    def ask(self, *words):
        done = self.cli(*words, "--json")
        if done.returncode not in (0, 1):
            raise Trouble("driftwise %s: %s" % (" ".join(map(str, words)), done.stderr.strip()))
        return json.loads(done.stdout or "{}")

    def tell(self, line):
        host, port = self.ready["control"].rsplit(":", 1)
        with socket.create_connection((host, int(port)), 5) as peer:
            peer.sendall((line + "\n").encode())
            return peer.makefile().readline().strip()

    def rows(self, query, database=None):
        with contextlib.closing(sqlite3.connect("file:%s?mode=ro" % (database or self.database), uri=True, timeout=20)) as record:
            return record.execute(query).fetchall()

    def count(self, query):
        return self.rows(query)[0][0] or 0

    def begin(self, plan, name="campaign"):
        path = self.folder / (name + ".csv")
        path.write_text(plan)
        answer = self.ask("run", "start", path, "--name", name)
        return (answer.get("run") or answer)["id"]

    def state(self, run):
        return self.rows("SELECT state, reason, accepted, given_up FROM run_progress WHERE run_id = %d" % run)[0]

    def points(self, run):
        """Row -> hash of what is stored of its point."""
        points = collections.defaultdict(list)
        for row, *rest in self.rows("SELECT trajectory_row, point_id, datum_id, measured_ns, (SELECT group_concat(channel_id || '=' || value) "
                                    "FROM point_value v WHERE v.point_id = p.point_id) FROM planned_point p WHERE run_id = %d" % run):
            points[row].append(hashlib.sha256(repr(rest).encode()).hexdigest())
        return points

    def end_run(self, run, seconds=120, resume=True):
        """Until it is over; a stop that says why is resumed as a person does. Result: stops that were explained."""
        explained, until, last, moved = [], time.monotonic() + seconds, None, time.monotonic()
        while True:
            state, reason, accepted, given_up = self.state(run)
            if state in ("done", "aborted", "failed"):
                if state != "done":
                    explained.append("%s: %s" % (state, reason))
                    if not reason:
                        raise Trouble("run %s without a reason" % state)
                return explained
            if (accepted, given_up, state, reason) != last:
                last, moved = (accepted, given_up, state, reason), time.monotonic()
            if state == "paused" and resume:
                if not reason:
                    raise Trouble("run paused without a reason")
                explained.append("paused: " + reason)
                if self.cli("run", "resume", run, "--yes").returncode == 0:
                    time.sleep(0.2)
            if state == "waiting" and resume and time.monotonic() - moved > 8:
                if not reason:
                    raise Trouble("run waits without a reason")
                if self.cli("run", "resume", run, "--yes").returncode == 0:
                    explained.append("waited for a person: " + reason)
                    moved = time.monotonic()
            if time.monotonic() > until:
                raise Trouble("after %d s the run is %s: %s" % (seconds, state, reason))
            time.sleep(0.05)

    def judge(self, run, told=0, before=None):
        """Lost and doubled rows of a run that is over: by the rows of the tables, not by our store."""
        points = self.points(run)
        rows = self.count("SELECT trajectory_rows FROM run WHERE run_id = %d" % run)
        accepted, given_up = self.state(run)[2:]
        lost = max(0, rows - len(points) - given_up) if self.state(run)[0] == "done" else 0
        lost += max(0, told - len(points))
        for row, hashes in (before or {}).items():
            lost += any(one not in points.get(row, []) for one in hashes)
        doubled = sum(len(one) - 1 for one in points.values())
        doubled += self.count("SELECT count(*) FROM (SELECT 1 FROM attempt WHERE verdict = 'accepted' GROUP BY run_id, trajectory_row "
                              "HAVING count(*) > 1)")
        doubled += abs(self.count("SELECT count(*) FROM planned_point") -
                       self.count("SELECT count(*) FROM attempt WHERE verdict = 'accepted'"))
        if self.rows("PRAGMA integrity_check") != [("ok",)]:
            raise Trouble("the file is damaged")
        return lost, doubled

    def alarms(self):
        """What left the machine: each alarm of the record is told once, within ten seconds of the end."""
        end = time.monotonic() + 10
        while True:
            told = collections.Counter((kind, subject) for kind, subject, _ in self.receiver.told)
            untold = sum((collections.Counter(self.rows("SELECT kind, subject FROM alarm")) - told).values())
            if untold == 0 or time.monotonic() > end:
                break
            time.sleep(0.1)
        time.sleep(0.3)  # one that is told twice comes right after
        return {"incidents": len(self.receiver.told), "untold": untold,
                "told_twice": sum(count > 1 for count in self.receiver.told.values())}

    def close(self):
        for process, how in ((self.daemon, signal.SIGTERM), (self.plant, signal.SIGTERM)):
            if process is None or process.poll() is not None:
                continue
            process.send_signal(how)
            try:
                process.wait(20)
            except subprocess.TimeoutExpired:
                process.kill()
                process.wait()
        if self.receiver:
            self.receiver.close()
        if self.wires:
            self.wires.close()
        self.log.close()
        self.scratch.cleanup()

    def __enter__(self):
        return self

    def __exit__(self, *unused):
        self.close()


def plan_of(kind, lines, per_line):
    if kind == "linear-axis":
        text = "q1_mm,set,line,zero\n"
        for line in range(1, lines + 1):
            for k in range(per_line):
                q = 0 if k == 0 else -2 + 4 * k / per_line + 0.125 * (line % 2)
                text += "%.4f,%s,%d,%d\n" % (q, "validation" if k % 2 else "calibration", line, k == 0)
        return text
    text = "q1_mm,q2_mm,q3_mm,set,line,zero\n"
    for line in range(1, lines + 1):
        for k in range(per_line):
            q = 0 if k == 0 else 0.2 + 2.0 * k / per_line + 0.05 * (line % 2)
            text += "%.4f,%.4f,%.4f,%s,%d,%d\n" % (q, q, q, "validation" if k % 2 else "calibration", line, k == 0)
    return text
