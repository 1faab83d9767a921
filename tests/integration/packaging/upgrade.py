#!/usr/bin/python3
"""The package from its installation to its removal, with an upgrade in the middle of a queue.

Usage: upgrade.py BUILD_FOLDER NEWER_BUILD_FOLDER    or of each the package: upgrade.py --pack BUILD_FOLDER VERSION PACKAGE
The newer build has -DDRIFTWISE_TEST_SCHEMA_STEP=ON: a schema step that exists in the tests only. Both are packed here,
the second one with a higher version, when that was not done before, and installed by dpkg in a root of its own: the host's files under an overlay, in
mount and process namespaces of their own. Systemd does not run there: a `systemctl` of this test starts and stops what
the unit names, as its user and in its folder. Exit code 77: no root, no overlay, or no cpack.
"""
import contextlib
import json
import os
import pathlib
import re
import shutil
import sqlite3
import subprocess
import sys
import tempfile
import time

SKIPPED = 77
SYSTEMCTL = '''#!/usr/bin/python3
import os, re, signal, subprocess, sys, time
words = [one for one in sys.argv[1:] if not one.startswith("-")]
verb, names = words[0], words[1:]
state = "/run/systemd/system"
def cells():
    return [one[:-4] for one in os.listdir(state) if one.endswith(".pid")]
def stop(cell):
    pid = int(open(f"{state}/{cell}.pid").read())
    os.kill(pid, signal.SIGTERM)
    for _ in range(600):
        if not os.path.exists(f"/proc/{pid}") or open(f"/proc/{pid}/stat").read().split(")")[1].split()[0] == "Z": break
        time.sleep(0.1)
    os.remove(f"{state}/{cell}.pid")
def start(cell):
    unit = open("/usr/lib/systemd/system/driftwised@.service").read()
    command = re.search(r"^ExecStart=(.*)$", unit, re.M)[1].replace("%i", cell).split()
    user = re.search(r"^User=(.*)$", unit, re.M)[1]
    log = open("/var/log/driftwised.log", "ab")
    started = subprocess.Popen(["setpriv", "--reuid", user, "--regid", user, "--clear-groups", "--"] + command,
                               cwd="/var/lib/driftwise/" + cell, stdout=log, stderr=log, start_new_session=True)
    open(f"{state}/{cell}.pid", "w").write(str(started.pid))
wanted = []
for name in names:
    cell = re.match(r"driftwised@(.*?)(\\.service)?$", name)[1]
    wanted += cells() if cell == "*" else [cell]
for cell in wanted:
    if verb in ("stop", "restart", "try-restart") and cell in cells(): stop(cell); again = True
    else: again = False
    if verb in ("start", "restart") or (verb == "try-restart" and again): start(cell)
'''


def check(condition, sentence):
    print(("ok: " if condition else "FAILED: ") + sentence, flush=True)
    if not condition:
        with contextlib.suppress(OSError):
            print(open("/var/log/driftwised.log", errors="replace").read()[-3000:])
        raise SystemExit(1)


def said(*command, **more):
    done = subprocess.run([str(word) for word in command], stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, **more)
    check(done.returncode == 0, " ".join(map(str, command[:4])) + ("" if done.returncode == 0 else ": " + done.stdout[-1500:]))
    return done.stdout


def until(what, condition, seconds=180):
    end = time.monotonic() + seconds
    while not condition():
        if time.monotonic() > end:
            check(False, "within %d s: %s" % (seconds, what))
        time.sleep(0.1)
    check(True, what)


def pack(build, folder, version):
    done = subprocess.run(["cpack", "--config", build + "/CPackConfig.cmake", "-G", "DEB", "-B", str(folder), "-D", "CPACK_PACKAGE_VERSION=" + version],
                          capture_output=True, text=True)
    check(done.returncode == 0, "packed: version %s%s" % (version, "" if done.returncode == 0 else done.stdout + done.stderr))
    return next(folder.glob("*.deb"))


def outside(packages):
    """This script again as process 1 of namespaces of its own, in a root whose changes go into a memory disk."""
    with tempfile.TemporaryDirectory(prefix="driftwise-upgrade-") as folder:
        script = """
set -e
mount -t tmpfs tmpfs {0}
mkdir {0}/upper {0}/work {0}/root
mount -t overlay overlay -o lowerdir=/,upperdir={0}/upper,workdir={0}/work {0}/root
mount --rbind /dev {0}/root/dev
mount -t proc proc {0}/root/proc
mount -t tmpfs tmpfs {0}/root/run
mount -t tmpfs tmpfs {0}/root/tmp
mkdir -p {0}/root/packages
cp {1} {0}/root/packages/a.deb
cp {2} {0}/root/packages/b.deb
cp {3} {0}/root/packages/upgrade.py
exec chroot {0}/root /usr/bin/python3 -B /packages/upgrade.py --inside
""".format(folder, packages[0], packages[1], os.path.abspath(__file__))
        return subprocess.run(["unshare", "--mount", "--pid", "--fork", "--kill-child", "bash", "-c", script]).returncode


def daemons():
    return [pid for pid in os.listdir("/proc") if pid.isdigit() and pathlib.Path("/proc", pid, "comm").read_text().strip() == "driftwised"
            and "Z" != pathlib.Path("/proc", pid, "stat").read_text().split(")")[1].split()[0]]


def rows(query, record="/var/lib/driftwise/axis/driftwise.sqlite"):
    with contextlib.closing(sqlite3.connect("file:%s?mode=ro" % record, uri=True, timeout=30)) as database:
        return database.execute(query).fetchall()


def plan(lines):
    text = "q1_mm,set,line,zero\n"
    for line in range(1, lines + 1):
        for k in range(6):
            text += "%.3f,%s,%d,%d\n" % (0 if k == 0 else -2 + 0.7 * k, "validation" if k % 2 else "calibration", line, k == 0)
    return text


def inside():
    cell = pathlib.Path("/var/lib/driftwise/axis")
    os.makedirs("/run/systemd/system")
    pathlib.Path("/usr/bin/systemctl").unlink(missing_ok=True)
    pathlib.Path("/usr/bin/systemctl").write_text(SYSTEMCTL)
    os.chmod("/usr/bin/systemctl", 0o755)
    subprocess.run(["ip", "link", "set", "lo", "up"], capture_output=True)
    check(not shutil.which("driftwised"), "the root has no Driftwise")
    said("dpkg", "--install", "/packages/a.deb")
    old = re.search(r"Version: (\S+)", said("dpkg", "--status", "driftwise"))[1]
    check(subprocess.run(["id", "driftwise"], capture_output=True).returncode == 0, "the account is there")
    check(not daemons(), "the installation starts nothing")

    share = "/usr/share/driftwise/cells/linear-axis"
    plant_file = pathlib.Path(share, "plant.toml")
    cell.mkdir(parents=True)
    plant = subprocess.Popen(["driftwise-cellsim", "--plant", plant_file, "--cell", share + "/cell.toml", "--instantiate", cell, "--speed", "100",
                              "--seed", "1"], stdout=subprocess.PIPE, text=True)
    check(plant.stdout.readline().startswith("READY "), "the simulated cell of the package answers")
    said("chown", "-R", "driftwise:driftwise", cell.parent)
    said("chmod", "o+rx", cell)
    said("systemctl", "start", "driftwised@axis")
    until("the daemon answers", lambda: (cell / "driftwised.json").exists(), 60)

    def ask(*words):
        done = subprocess.run(["setpriv", "--reuid", "driftwise", "--regid", "driftwise", "--clear-groups", "--", "driftwise", *map(str, words), "--json"],
                              cwd=cell, capture_output=True, text=True, timeout=180)
        check(done.returncode in (0, 1), "driftwise %s%s" % (" ".join(map(str, words[:2])), "" if done.returncode in (0, 1) else ": " + done.stderr))
        return json.loads(done.stdout or "{}")

    for name, lines in (("first", 2), ("second", 8), ("third", 2)):
        path = pathlib.Path("/tmp", name + ".csv")
        path.write_text(plan(lines))
        os.chmod(path, 0o644)
    ask("run", "start", "/tmp/first.csv")
    until("the run is over", lambda: rows("SELECT count(*) FROM run_progress WHERE state = 'done'")[0][0] == 1)
    check(rows("SELECT state FROM run_progress WHERE run_id = 1") == [("done",)], "a run was measured")
    for name in ("first", "second", "third"):
        ask("queue", "add", "/tmp/%s.csv" % name, "--name", name)
    until("the second of three campaigns has points", lambda: rows("SELECT count(*) FROM planned_point WHERE run_id = 3")[0][0] >= 4)
    version = rows("PRAGMA user_version")[0][0]
    told = rows("SELECT point_id, run_id, trajectory_row, measured_ns FROM point ORDER BY point_id")

    first_pid = daemons()
    said("dpkg", "--install", "/packages/b.deb")
    new = re.search(r"Version: (\S+)", said("dpkg", "--status", "driftwise"))[1]
    check(subprocess.run(["dpkg", "--compare-versions", new, "gt", old]).returncode == 0, "version %s took the place of %s" % (new, old))
    until("the new daemon runs", lambda: len(daemons()) == 1 and daemons() != first_pid, 60)
    until("the record has the step", lambda: rows("PRAGMA user_version")[0][0] == version + 1, 60)
    kept = "%s/driftwise.sqlite.version-%d" % (cell, version)
    check(os.path.exists(kept), "a copy of the old version was kept: " + os.path.basename(kept))
    check(rows("PRAGMA user_version", kept)[0][0] == version and rows("PRAGMA integrity_check", kept) == [("ok",)], "it is whole and of the old version")
    of_copy = rows("SELECT point_id, run_id, trajectory_row, measured_ns FROM point ORDER BY point_id", kept)
    check(of_copy[:len(told)] == told, "it has every point that was there before the upgrade")
    check(not rows("SELECT name FROM sqlite_master WHERE name = 'upgraded'", kept) and rows("SELECT name FROM sqlite_master WHERE name = 'upgraded'"),
          "the new table is in the record alone")

    until("the queue is done", lambda: rows("SELECT count(*) FROM queue_entry WHERE state = 'done'")[0][0] == 3, 300)
    for run, wanted in ((2, 12), (3, 48), (4, 12)):
        found = rows("SELECT trajectory_row, count(*) FROM planned_point WHERE run_id = %d GROUP BY trajectory_row" % run)
        check(len(found) == wanted and all(count == 1 for _, count in found), "run %d has each of its %d rows once" % (run, wanted))
    after = rows("SELECT point_id, run_id, trajectory_row, measured_ns FROM point ORDER BY point_id")
    check(after[:len(told)] == told, "no point of before has changed")
    said("driftwise", "audit", "verify", "--database", cell / "driftwise.sqlite")

    said("dpkg", "--remove", "driftwise")
    check(not daemons(), "nothing is left running")
    check(not shutil.which("driftwised") and not shutil.which("driftwise"), "the programs are gone")
    plant.terminate()
    check(rows("SELECT count(*) FROM point")[0][0] == len(after) and rows("PRAGMA integrity_check") == [("ok",)], "the record is kept, whole")
    purged = said("dpkg", "--purge", "driftwise")
    check("stay" in purged and (cell / "driftwise.sqlite").exists(), "a purge says what stays, and the record does")


def main():
    if sys.argv[1] == "--inside":
        inside()
        return 0
    if sys.argv[1] == "--pack":
        with tempfile.TemporaryDirectory(prefix="driftwise-packages-") as folder:
            shutil.copy(pack(sys.argv[2], pathlib.Path(folder), sys.argv[3]), sys.argv[4])
        return 0
    probe = "d=$(mktemp -d) && mount -t tmpfs t $d && mkdir $d/u $d/w $d/r && mount -t overlay o -o lowerdir=/,upperdir=$d/u,workdir=$d/w $d/r"
    if os.geteuid() != 0 or not shutil.which("cpack") or subprocess.run(["unshare", "--mount", "bash", "-c", probe], capture_output=True).returncode != 0:
        print("NOT TESTED: needs root, mount namespaces with overlays, and cpack")
        return SKIPPED
    with tempfile.TemporaryDirectory(prefix="driftwise-packages-") as folder:
        packages = []
        for build, version in zip(sys.argv[1:3], ("0.1.0", "0.1.1")):
            if build.endswith(".deb"):
                packages.append(os.path.abspath(build))
                continue
            at = pathlib.Path(folder, version)
            at.mkdir()
            packages.append(pack(build, at, version))
        return outside(packages)


if __name__ == "__main__":
    sys.exit(main())
