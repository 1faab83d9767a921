#!/usr/bin/python3
"""driftwise-cellsim as a process: faults on demand, chopped replies, refused clients, and errors that say what is wrong."""
import os
import select
import socket
import subprocess
import sys
import tempfile
import time

from cellsim_process import Cellsim, check


class Line:
    def __init__(self, port):
        self.socket = socket.create_connection(("127.0.0.1", port), timeout=10)
        self.socket.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
        self.buffer, self.pieces = b"", 0

    def ask(self, text):
        try:
            self.socket.sendall(text.encode() + b"\n")
        except ConnectionError:  # refused: how soon the reset is seen is the kernel's business
            return None
        while b"\n" not in self.buffer:
            try:
                piece = self.socket.recv(65536)
            except ConnectionError:
                return None
            if not piece:
                return None
            self.pieces += 1
            self.buffer += piece
        line, self.buffer = self.buffer.split(b"\n", 1)
        return line.decode("latin-1")

    def silent_for(self, seconds):
        return not select.select([self.socket], [], [], seconds)[0]


def faults():
    with Cellsim(speed=100) as cell:
        desk, laser, axis = Line(cell.port("control")), Line(cell.port("laser-x")), Line(cell.port("axis"))
        check(laser.ask("ZERO 1") == "OK", "the interferometer is zeroed")
        check(laser.ask("MEAS? 1").startswith("OK ch=1 "), "and measures")
        check(desk.ask("fault break-beam") == "OK" and laser.ask("MEAS? 1").startswith("ERR 3 "), "a broken beam is ERR 3")
        check(laser.ask("ZERO 1") == "OK" and laser.ask("MEAS? 1").startswith("OK "), "until it is zeroed")
        check(desk.ask("fault garble laser-x") == "OK" and not laser.ask("IDN?").startswith("OK SIOS SP-2000 SP2000-0471 ch=1"),
              "a garbled reply")
        check(laser.ask("IDN?") == "OK SIOS SP-2000 SP2000-0471 ch=1", "and the next one is right")
        check(desk.ask("fault mute axis 30 s") == "OK", "the controller is mute")
        axis.socket.sendall(b"POS?\n")
        check(axis.silent_for(0.1), "and says nothing")
        time.sleep(0.4)
        check(axis.ask("POS?").startswith("X="), "and is back 30 s of cell time later")
        check(desk.ask("fault slow axis 20 s") == "OK", "the controller is slow")
        begin = time.monotonic()
        axis.ask("POS?")
        check(time.monotonic() - begin >= 0.2, "20 s of cell time are 0.2 s at speed 100")
        check(desk.ask("fault clear axis") == "OK" and desk.ask("fault drop axis") == "OK", "the connection is cut")
        check(axis.socket.recv(10) == b"", "which the client sees")
        check(Line(cell.port("axis")).ask("POS?").startswith("X="), "and may come again")
        check(desk.ask("fault open-probe 103") == "OK" and desk.ask("fault open-probe 1").startswith("ERR "), "a wire breaks")
        check('"end_effector_nm"' in desk.ask("truth?"), "the truth is told here and nowhere else")
        scanner, second = Line(cell.port("scanner")), Line(cell.port("scanner"))
        check(scanner.ask("*OPT?") == "7700,NONE" and second.ask("*OPT?") is None, "the scanner takes one client")
        scanner.ask("*RST;*CLS;*OPC?")
        scanner.socket.sendall(b"INIT:CONT OFF;:FORM:ELEM READ;:FUNC 'FRES',(@101:110);:SAMP:COUN 10;:ROUT:SCAN (@101:110)\n")
        scanner.socket.sendall(b"ROUT:SCAN:LSEL INT\n")
        readings = scanner.ask("READ?").split(",")
        check(len(readings) == 10 and readings[2] == "+9.9E37" and readings[3] != "+9.9E37", "the open probe overflows")


def chopping():
    pieces = {}
    for chop in ("true", "false"):
        with Cellsim("wire.chop=" + chop, "wire.pause_us=2000") as cell:
            axis = Line(cell.port("axis"))
            for _ in range(100):
                axis.ask("*IDN?")
            pieces[chop] = axis.pieces
    check(pieces["false"] == 100, "without chopping one piece per reply, found %d" % pieces["false"])
    check(pieces["true"] > 115, "with chopping more, found %d" % pieces["true"])


def instance():
    with Cellsim() as cell:
        with open(os.path.join(cell.folder.name, "cell.toml")) as file:
            text = file.read()
        for device in ("axis", "scanner", "laser-x", "support"):
            check('"%s"' % cell.address[device] in text, "cell.toml has the address of " + device)
        check("speed = 200" in text and 'listen = "127.0.0.1:0"' in text, "and the speed and free ports")
        check(os.path.getsize(os.path.join(cell.folder.name, "clock.state")) == 64, "the clock has 64 bytes")
        with open(os.path.join(cell.folder.name, "truth.csv")) as file:
            check("end_effector_nm" in file.readline(), "the truth log has its header")


def errors():
    binary, source = sys.argv[1], sys.argv[2]
    cell = source + "/deploy/cells/linear-axis/cell.toml"
    plant = source + "/deploy/cells/linear-axis/plant.toml"
    folder = tempfile.TemporaryDirectory()
    bad = folder.name + "/bad.toml"
    with open(bad, "w") as file:
        file.write("[[device]]\nid = 7\n")

    def refused(code, words, *arguments):
        run = subprocess.run([binary, *arguments], capture_output=True, text=True, timeout=60)
        check(run.returncode == code and words in run.stderr and "READY" not in run.stdout,
              "%d, %s: %s" % (code, words, run.stderr.strip()))

    refused(2, "--plant and --cell")
    refused(2, "--sped", "--sped", "3")
    refused(3, "bad.toml:2: device id", "--plant", plant, "--cell", bad, "--instantiate", folder.name)
    refused(3, "cannot be read", "--plant", "/no/plant.toml", "--cell", cell, "--instantiate", folder.name)
    refused(3, "there is no switch 'foo'", "--plant", plant, "--cell", cell, "--instantiate", folder.name,
            "--set", "emulator.pi.foo=1")
    refused(3, "expected true or false", "--plant", plant, "--cell", cell, "--instantiate", folder.name,
            "--set", "emulator.pi.ini=perhaps")
    refused(3, "room.wander_w", "--plant", plant, "--cell", cell, "--instantiate", folder.name,
            "--set", "room.wander_w=much")
    refused(3, "without --instantiate", "--plant", plant, "--cell", cell, "--speed", "7")
    shown = subprocess.run([binary, "--help"], capture_output=True, text=True)
    check(shown.returncode == 0 and "Examples:" in shown.stdout, "--help shows examples")


faults()
chopping()
instance()
errors()
