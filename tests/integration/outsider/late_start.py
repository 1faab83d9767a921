#!/usr/bin/env python3
"""A start while the record takes nothing: the daemon waits, says for what, and starts by itself. The program in its way is
Python's own sqlite3 with a transaction that it does not end."""
import os
import signal
import sqlite3
import subprocess
import sys

import cell as outside
from cell import BIN, Cell, check, until


def begin(cell):
    if os.path.exists(cell.path("driftwised.json")):
        os.remove(cell.path("driftwised.json"))
    log = cell.path("late.log")
    with open(log, "wb") as file:
        daemon = subprocess.Popen([BIN + "/driftwised", "--cell", cell.path("cell.toml")], stdout=file, stderr=file)

    def says(words):
        with open(log, encoding="utf-8") as opened:
            return words in opened.read()

    return daemon, says


def main():
    with Cell(access=False) as cell:
        cell.stop()
        other = sqlite3.connect(cell.database(), isolation_level=None)
        other.execute("BEGIN IMMEDIATE")
        daemon, says = begin(cell)
        until("the sentence of the log", lambda: says("cannot start yet") or daemon.poll() is not None)
        check(daemon.poll() is None, "a daemon whose record is held waits")
        check(says("DATABASE_LOCKED") and says("tries again every 10 s, by itself"), "  it says for what, and what comes next")
        check(not os.path.exists(cell.path("driftwised.json")), "  it is not ready meanwhile")
        daemon.send_signal(signal.SIGTERM)
        check(daemon.wait(30) == 0, "a waiting daemon ends when it is told to")
        cell.daemon, says = begin(cell)
        until("the sentence of the log", lambda: says("cannot start yet"))
        other.execute("ROLLBACK")
        until("the start", lambda: os.path.exists(cell.path("driftwised.json")))
        check("values" in cell.ask("status"), "it starts by itself when the record is free")
    print(f"{outside.passed} checks passed")


if __name__ == "__main__":
    sys.exit(main())
