#!/usr/bin/python3
# Origin: peers/modbus/pid_peer.py of the Driftwise project material, copied unchanged below this line: an independent
# Modbus server (Debian's python3-pymodbus) that shares no code with the driver under test.
"""Simulated PID temperature controllers on Modbus TCP and/or Modbus RTU.

The protocol side is Debian's python3-pymodbus (3.0.x; also needs
python3-serial-asyncio, and socat for --rtu); only the register contents and
the small thermal model below are ours.

    pid_peer.py --tcp 1502                       Modbus TCP on 127.0.0.1:1502
    pid_peer.py --rtu ./pid-rtu               Modbus RTU on a pty; clients open
                                                 the link ./pid-rtu
    options: --baud 9600  --speed 60 (model seconds per wall second)
             --noise 0.0005 (sensor noise, degC)  --ambient 20.0

Prints "READY tcp 127.0.0.1:PORT" / "READY rtu LINK". Stops on SIGTERM/SIGINT.

Units (slave addresses):
  1  Watlow EZ-ZONE PM style: float32 in two holding registers, LOW word
     first, temperatures in degF unless register 2490 holds 15 (30 = degF)
       360 PV | 362 input error (61 none, 65 open) | 1880 control mode
       (10 auto, 54 manual, 62 off) | 1890/1892 heat/cool proportional band |
       1894 Ti s | 1896 Td s | 1904/1906 heat/cool power % | 2160 set point |
       2162 open-loop set point % | 2490 comms units
  2  Eurotherm 3200 style: signed 16-bit scaled by 10**DECIMALS (525 holds
     DECIMALS), plus full floats at 0x8000+2*addr, HIGH word first
       1 PV | 2 target SP | 3 manual OP % | 4 working OP % | 5 working SP |
       6 PB | 8 Ti s | 9 Td s | 13 alarm 1 threshold (high) | 24 SP1 |
       26 remote SP | 75 status bits | 258 sensor break | 273 auto/manual
  10 fault desk (not a real device), write 1 to trigger, 0 to clear:
       0 open sensor on unit 1 | 1 open sensor on unit 2
Reading or writing any other address gives exception 2 (illegal address); a
request to any other unit gets no answer.
"""
import argparse
import asyncio
import logging
import os
import random
import signal
import struct
import subprocess
import sys
import time

from pymodbus.datastore import ModbusServerContext, ModbusSlaveContext
from pymodbus.datastore import ModbusSparseDataBlock
from pymodbus.server.async_io import ModbusSerialServer, ModbusTcpServer
from pymodbus.transaction import ModbusRtuFramer, ModbusSocketFramer


class Loop:
    """PID on a two-time-constant plant; temperatures in degC, output -100..100 %."""

    def __init__(self, ambient, noise):
        self.t = self.sensor = self.pv = ambient
        self.ambient, self.noise = ambient, noise
        self.sp, self.manual, self.mode = ambient, 0.0, "auto"
        self.pb, self.ti, self.td = 2.0, 60.0, 0.0    # pb: degC for 100 %
        self.i = self.out = 0.0
        self.broken = False

    def step(self, dt):
        self.t += dt * ((self.ambient - self.t) / 600.0 + 0.02 * self.out / 100.0)
        old = self.sensor
        self.sensor += dt * (self.t - self.sensor) / 5.0
        self.pv = self.sensor + random.gauss(0.0, self.noise)
        if self.broken or self.mode == "off":
            self.out, self.i = 0.0, 0.0
        elif self.mode == "manual":
            self.out = self.manual
        else:
            gain = 100.0 / max(self.pb, 1e-3)
            err = self.sp - self.pv
            if self.ti > 0:
                i = self.i + gain * err * dt / self.ti
                self.i = max(-100.0, min(100.0, i))
            d = -gain * self.td * (self.sensor - old) / dt
            self.out = max(-100.0, min(100.0, gain * err + self.i + d))


def f2w(x, low_first):
    hi, lo = struct.unpack(">HH", struct.pack(">f", x))
    return [lo, hi] if low_first else [hi, lo]


def w2f(w, low_first):
    hi, lo = (w[1], w[0]) if low_first else (w[0], w[1])
    return struct.unpack(">f", struct.pack(">HH", hi, lo))[0]


class Block(ModbusSparseDataBlock):
    """Register block that lets the model refresh before a read and see a write."""

    def __init__(self, values, on_write):
        super().__init__(values)
        self.on_write = on_write

    def setValues(self, address, values, use_as_default=False):
        super().setValues(address, values, use_as_default)
        n = len(values) if isinstance(values, (list, tuple)) else 1
        self.on_write(address, n)

    def put(self, address, words):
        for k, w in enumerate(words):
            self.values[address + k] = w & 0xFFFF

    def get(self, address, n=1):
        return [self.values[address + k] for k in range(n)]


class Watlow:
    FLOATS = (360, 1890, 1892, 1894, 1896, 1904, 1906, 2160, 2162)
    WORDS = (362, 1880, 2490)

    def __init__(self, loop):
        self.m = loop
        regs = {}
        for a in self.FLOATS:
            regs[a] = regs[a + 1] = 0
        for a in self.WORDS:
            regs[a] = regs[a + 1] = 0
        self.b = Block(regs, self.written)
        self.b.put(2490, [30])
        self.b.put(1880, [10])
        self.refresh()

    def degf(self):
        return self.b.get(2490)[0] != 15

    def out_t(self, c):
        return c * 1.8 + 32.0 if self.degf() else c

    def in_t(self, v):
        return (v - 32.0) / 1.8 if self.degf() else v

    def refresh(self):
        m, f = self.m, lambda a, x: self.b.put(a, f2w(x, True))
        k = 1.8 if self.degf() else 1.0
        f(360, self.out_t(m.pv))
        self.b.put(362, [65 if m.broken else 61])
        f(1890, m.pb * k), f(1892, m.pb * k), f(1894, m.ti), f(1896, m.td)
        f(1904, max(m.out, 0.0)), f(1906, max(-m.out, 0.0))
        f(2160, self.out_t(m.sp)), f(2162, m.manual)

    def written(self, a, n):
        m, k = self.m, (1.8 if self.degf() else 1.0)
        for x in range(a, a + n):
            if x in (1891, 1893, 1895, 1897, 2161, 2163):
                v = w2f(self.b.get(x - 1, 2), True)
                if x in (1891, 1893):
                    m.pb = v / k
                elif x == 1895:
                    m.ti = v
                elif x == 1897:
                    m.td = v
                elif x == 2161:
                    m.sp = self.in_t(v)
                else:
                    m.manual = max(-100.0, min(100.0, v))
            elif x == 1880:
                m.mode = {10: "auto", 54: "manual", 62: "off"}.get(self.b.get(x)[0], m.mode)
        self.refresh()


class Eurotherm:
    # address -> scaled by decimals?
    REGS = {1: 1, 2: 1, 3: 2, 4: 2, 5: 1, 6: 1, 8: 0, 9: 0, 13: 1, 24: 1, 26: 1,
            75: 0, 258: 0, 273: 0, 525: 0}

    def __init__(self, loop, decimals):
        self.m, self.dec, self.alarm1, self.remote = loop, decimals, 50.0, 0.0
        regs = {}
        for a in self.REGS:
            regs[a] = regs[0x8000 + 2 * a] = regs[0x8000 + 2 * a + 1] = 0
        self.b = Block(regs, self.written)
        self.refresh()

    def scale(self, a):
        return {0: 1.0, 1: 10.0 ** self.dec, 2: 10.0}[self.REGS[a]]

    def refresh(self):
        m = self.m
        hi = m.pv > self.alarm1
        vals = {1: m.pv, 2: m.sp, 3: m.manual, 4: m.out, 5: m.sp, 6: m.pb, 8: m.ti,
                9: m.td, 13: self.alarm1, 24: m.sp, 26: self.remote,
                75: (1 if hi else 0) | (16 if m.mode == "manual" else 0) | (32 if m.broken else 0),
                258: int(m.broken), 273: int(m.mode == "manual"), 525: self.dec}
        for a, v in vals.items():
            n = int(round(v * self.scale(a)))
            self.b.put(a, [max(-32768, min(32767, n))])
            self.b.put(0x8000 + 2 * a, f2w(float(v), False))

    def written(self, a, n):
        m = self.m
        for x in range(a, a + n):
            if x >= 0x8000:
                if not x & 1:
                    continue
                reg, v = (x - 0x8001) // 2, w2f(self.b.get(x - 1, 2), False)
            else:
                w = self.b.get(x)[0]
                reg, v = x, (w - 65536 if w > 32767 else w) / self.scale(x)
            if reg in (2, 24, 26):
                m.sp = v
                self.remote = v if reg == 26 else self.remote
            elif reg == 3:
                m.manual = max(-100.0, min(100.0, v))
            elif reg == 6:
                m.pb = v
            elif reg == 8:
                m.ti = v
            elif reg == 9:
                m.td = v
            elif reg == 13:
                self.alarm1 = v
            elif reg == 273:
                m.mode = "manual" if v else "auto"
        self.refresh()


async def main():
    # pymodbus 3.0 logs every client disconnect as an error
    logging.getLogger("pymodbus").setLevel(logging.CRITICAL)
    ap = argparse.ArgumentParser(description="simulated Modbus PID controllers")
    ap.add_argument("--tcp", type=int, metavar="PORT")
    ap.add_argument("--rtu", metavar="LINK")
    ap.add_argument("--baud", type=int, default=9600)
    ap.add_argument("--speed", type=float, default=60.0)
    ap.add_argument("--noise", type=float, default=0.0005)
    ap.add_argument("--ambient", type=float, default=20.0)
    ap.add_argument("--decimals", type=int, default=1, choices=(0, 1, 2))
    a = ap.parse_args()
    if not a.tcp and not a.rtu:
        ap.error("give --tcp and/or --rtu")

    loops = [Loop(a.ambient, a.noise), Loop(a.ambient, a.noise)]
    wat, eur = Watlow(loops[0]), Eurotherm(loops[1], a.decimals)

    def fault(_a, _n):
        for k, m in enumerate(loops):
            m.broken = bool(desk.get(k)[0])
        wat.refresh(), eur.refresh()
    desk = Block({0: 0, 1: 0}, fault)

    none = ModbusSparseDataBlock({65535: 0})

    def slave(b):
        return ModbusSlaveContext(hr=b, ir=b, co=none, di=none, zero_mode=True)
    ctx = ModbusServerContext(
        slaves={1: slave(wat.b), 2: slave(eur.b), 10: slave(desk)}, single=False)

    stop = asyncio.Event()
    for s in (signal.SIGTERM, signal.SIGINT):
        asyncio.get_running_loop().add_signal_handler(s, stop.set)

    tasks, socat = [], None
    if a.tcp:
        tcp = ModbusTcpServer(ctx, framer=ModbusSocketFramer, address=("127.0.0.1", a.tcp),
                              allow_reuse_address=True)
        tasks.append(asyncio.create_task(tcp.serve_forever()))
        await asyncio.wait_for(tcp.serving, 5)
        print(f"READY tcp 127.0.0.1:{a.tcp}", flush=True)
    if a.rtu:
        mine = a.rtu + ".server"
        socat = subprocess.Popen(
            ["socat", f"PTY,link={mine},raw,echo=0", f"PTY,link={a.rtu},raw,echo=0"])
        for _ in range(50):
            if os.path.exists(mine) and os.path.exists(a.rtu):
                break
            await asyncio.sleep(0.1)
        # A real unit stays silent for addresses that are not its own.
        rtu = ModbusSerialServer(ctx, framer=ModbusRtuFramer, port=mine, baudrate=a.baud,
                                 bytesize=8, parity="N", stopbits=1, timeout=1,
                                 ignore_missing_slaves=True)
        await rtu.start()
        print(f"READY rtu {a.rtu}", flush=True)

    last = time.monotonic()
    while not stop.is_set():
        try:
            await asyncio.wait_for(stop.wait(), 0.05)
        except asyncio.TimeoutError:
            pass
        now = time.monotonic()
        left, last = (now - last) * a.speed, now
        while left > 0:
            dt = min(left, 0.5)
            for m in loops:
                m.step(dt)
            left -= dt
        wat.refresh(), eur.refresh()
    for t in tasks:
        t.cancel()
    if socat:
        socat.terminate()
        socat.wait()


if __name__ == "__main__":
    try:
        asyncio.run(main())
    except (asyncio.CancelledError, KeyboardInterrupt):
        sys.exit(0)
