"""Starts driftwise-cellsim for a test and stops it again; small helpers to compare."""
import json
import os
import signal
import subprocess
import sys
import tempfile

SKIPPED = 77  # ctest's SKIP_RETURN_CODE: the peer is not installed


class Cellsim:
    """with Cellsim("emulator.scanner.serial=true", speed=200) as cell: cell.address["scanner"]"""

    def __init__(self, *settings, speed=200):
        binary, source = sys.argv[1], sys.argv[2]
        cell = os.path.join(source, "deploy", "cells", "linear-axis")
        self.folder = tempfile.TemporaryDirectory(prefix="driftwise-peers-")
        command = [binary, "--plant", cell + "/plant.toml", "--cell", cell + "/cell.toml",
                   "--instantiate", self.folder.name, "--speed", str(speed)]
        for setting in settings:
            command += ["--set", setting]
        self.process = subprocess.Popen(command, stdout=subprocess.PIPE, text=True)
        line = self.process.stdout.readline()
        if not line.startswith("READY "):
            raise SystemExit("driftwise-cellsim did not start")
        self.address = json.loads(line[len("READY "):])

    def port(self, device):
        return int(self.address[device].rsplit(":", 1)[1])

    def __enter__(self):
        return self

    def __exit__(self, *unused):
        self.process.send_signal(signal.SIGTERM)
        code = self.process.wait(timeout=10)
        self.folder.cleanup()
        check(code == 0, "driftwise-cellsim ended with 0, found %r" % code)


def check(condition, sentence):
    print(("ok: " if condition else "FAILED: ") + sentence)
    if not condition:
        raise SystemExit(1)
