#!/usr/bin/python3
"""mbpoll (libmodbus) and a pymodbus client read and write the emulated Watlow controller."""
import shutil
import struct
import subprocess
import sys
import time

from cellsim_process import SKIPPED, Cellsim, check

try:
    from pymodbus.client.tcp import ModbusTcpClient
except ImportError:
    try:
        from pymodbus.client import ModbusTcpClient
    except ImportError:
        print("python3-pymodbus is not installed")
        sys.exit(SKIPPED)


def low_word_first(registers):
    return struct.unpack(">f", struct.pack(">HH", registers[1], registers[0]))[0]


def words(value):
    high, low = struct.unpack(">HH", struct.pack(">f", value))
    return [low, high]


def with_pymodbus(cell):
    client = ModbusTcpClient("127.0.0.1", port=cell.port("support"), timeout=3)
    check(client.connect(), "pymodbus connects")
    fahrenheit = low_word_first(client.read_holding_registers(360, 2, slave=1).registers)
    check(abs((fahrenheit - 32) / 1.8 - 23) < 0.5, "process value near 23 degC, found %.3f degF" % fahrenheit)
    check(client.read_holding_registers(2490, 1, slave=1).registers == [30], "units on the wire are degF")
    check(client.read_holding_registers(1880, 1, slave=1).registers == [10], "mode is auto")
    check(not client.write_registers(2160, words(24 * 1.8 + 32), slave=1).isError(), "a set point is taken")
    asked = low_word_first(client.read_holding_registers(2160, 2, slave=1).registers)
    check(abs(asked - (24 * 1.8 + 32)) < 1e-4, "and read back: %.4f degF" % asked)
    before = low_word_first(client.read_holding_registers(1904, 2, slave=1).registers)
    check(before > 0, "and the element heats: %.1f %%" % before)
    check(client.write_register(2490, 15, slave=1).isError() is False, "units change to degC")
    check(abs(low_word_first(client.read_holding_registers(2160, 2, slave=1).registers) - 24) < 1e-4, "set point in degC")
    check(client.read_holding_registers(3, 1, slave=1).exception_code == 2, "no such register is exception 2")
    check(client.read_coils(0, 1, slave=1).exception_code == 1, "another function is exception 1")
    check(client.write_registers(2160, words(500), slave=1).exception_code == 3, "500 degC is exception 3")
    client.close()


def with_mbpoll(cell):
    if shutil.which("mbpoll") is None:
        print("mbpoll is not installed")
        return
    # mbpoll takes the low word first unless told otherwise with -B, as the controller sends it.
    base = ["mbpoll", "-0", "-1", "-a", "1", "-p", str(cell.port("support")), "-o", "3"]
    read = subprocess.run(base + ["-t", "4:float", "-r", "2160", "127.0.0.1"], capture_output=True, text=True)
    value = [line.split("\t")[1] for line in read.stdout.splitlines() if line.startswith("[2160]")]
    check(read.returncode == 0 and abs(float(value[0]) - 24) < 1e-3, "mbpoll reads the set point: %s" % value)
    write = subprocess.run(base + ["-t", "4:float", "-r", "2160", "127.0.0.1", "23.25"], capture_output=True, text=True)
    check(write.returncode == 0, "mbpoll writes it")
    read = subprocess.run(base + ["-t", "4:float", "-r", "2160", "127.0.0.1"], capture_output=True, text=True)
    check("23.25" in read.stdout, "and reads 23.25")
    other = subprocess.run([*base[:4], "9", *base[5:], "-t", "4", "-r", "362", "127.0.0.1"], capture_output=True, text=True)
    check(other.returncode != 0, "unit 9 is silent")


def with_rtu(cell):
    if shutil.which("mbpoll") is None:
        return
    line = cell.address["support-serial"]
    read = subprocess.run(["mbpoll", "-0", "-1", "-m", "rtu", "-a", "1", "-b", "9600", "-P", "none", "-o", "3",
                           "-t", "4:float", "-r", "2160", line], capture_output=True, text=True)
    check(read.returncode == 0 and "23.25" in read.stdout, "mbpoll reads it over RTU on %s" % line)


# Slower than the others: an RTU frame that an interrupted writer sends in two pieces must stay one frame.
with Cellsim("emulator.watlow.rtu=true", "emulator.watlow.rtu_gap_s=2", speed=20) as under_test:
    with_pymodbus(under_test)
    with_mbpoll(under_test)
    with_rtu(under_test)
