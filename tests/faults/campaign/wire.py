"""Proxies between the daemon and the emulated devices: each carries one device's protocol and misbehaves on demand, at
whatever step of it the instant falls on."""
import asyncio
import random
import threading
import time

# What a device can do to its line; the rest (lies, broken beams) is done by the emulators themselves.
KINDS = ("drop", "freeze", "slow", "late", "other", "garble")


class Line:
    """One device's line. All of it is on the loop's thread but fault(), which only sets values."""

    def __init__(self, host, port, seed):
        self.target = (host, int(port))
        self.random = random.Random(seed)
        self.kind, self.until = None, 0.0
        self.replies = []  # the last ones, for an answer to another question
        self.writers = set()
        self.server = None
        self.port = None
        self.touched = 0  # replies that the present fault changed, held back or swallowed

    def active(self):
        return self.kind if time.monotonic() < self.until else None

    def fault(self, kind, seconds):
        self.touched = 0
        self.until = time.monotonic() + seconds
        self.kind = kind

    async def open(self):
        self.server = await asyncio.start_server(self.serve, "127.0.0.1", 0)
        self.port = self.server.sockets[0].getsockname()[1]

    def cut(self):
        for writer in list(self.writers):
            writer.transport.abort()

    async def serve(self, reader, writer):
        if self.active() == "drop":
            self.touched += 1
            writer.transport.abort()
            return
        try:
            up_reader, up_writer = await asyncio.open_connection(*self.target)
        except OSError:
            writer.transport.abort()
            return
        pair = {writer, up_writer}
        self.writers |= pair
        try:
            await asyncio.wait([asyncio.ensure_future(self.carry(reader, up_writer, False)),
                                asyncio.ensure_future(self.carry(up_reader, writer, True))],
                               return_when=asyncio.FIRST_COMPLETED)
        finally:
            self.writers -= pair
            for one in pair:
                one.transport.abort()

    async def carry(self, reader, writer, is_reply):
        try:
            while piece := await reader.read(65536):
                if is_reply:
                    piece = await self.reply(piece)
                if piece:
                    writer.write(piece)
                    await writer.drain()
        except (ConnectionError, asyncio.CancelledError, RuntimeError):
            pass

    async def reply(self, piece):
        kind = self.active()
        self.replies = (self.replies + [piece])[-6:]
        if kind is None:
            return piece
        self.touched += 1
        if kind == "freeze":
            return b""
        if kind == "slow":
            await asyncio.sleep(0.15)
        elif kind == "late":  # this one long after its question, the following ones in time
            self.until = 0
            await asyncio.sleep(4)
        elif kind == "other":
            return self.random.choice(self.replies[:-1] or [piece])
        elif kind == "garble":
            at = self.random.randrange(len(piece))
            return piece[:at] + bytes([piece[at] ^ self.random.randrange(1, 256)]) + piece[at + 1:]
        return piece


class Wires:
    def __init__(self, addresses, seed):
        self.loop = asyncio.new_event_loop()
        self.thread = threading.Thread(target=self.loop.run_forever, daemon=True)
        self.thread.start()
        self.lines = {}
        for number, (device, address) in enumerate(sorted(addresses.items())):
            line = Line(*address.rsplit(":", 1), seed + number)
            asyncio.run_coroutine_threadsafe(line.open(), self.loop).result(10)
            self.lines[device] = line

    def fault(self, device, kind, seconds):
        line = self.lines[device]
        line.fault(kind, seconds)
        if kind == "drop":
            self.loop.call_soon_threadsafe(line.cut)

    def close(self):
        async def end():
            for line in self.lines.values():
                line.server.close()
                line.cut()
        asyncio.run_coroutine_threadsafe(end(), self.loop).result(10)
        self.loop.call_soon_threadsafe(self.loop.stop)
        self.thread.join(10)
