"""Makes the one run of a cell's database 60 hours long: a reading a second of 30 channels, 6.5 million values.

python3 long_run.py DATABASE [HOURS]. The daemon must not run. Prints the channels, separated by commas.
"""
import math
import random
import sqlite3
import sys

SECOND_NS = 1_000_000_000
CHANNELS = 30

database = sqlite3.connect(sys.argv[1])
seconds = int(float(sys.argv[2] if len(sys.argv) > 2 else 60) * 3600)
started_ns, = database.execute("SELECT started_ns FROM run_progress WHERE run_id = 1").fetchone()
device, = database.execute("SELECT device_id FROM device WHERE name = 'scanner'").fetchone()
channels = database.execute(
    "SELECT channel_id, name FROM channel WHERE in_reading = 1 ORDER BY name LIKE 't%' DESC, name LIMIT ?", (CHANNELS,)).fetchall()
assert len(channels) == CHANNELS, f"only {len(channels)} channels"
first, = database.execute("SELECT max(reading_id) + 1 FROM reading").fetchone()
begin_ns = started_ns - seconds * SECOND_NS
random.seed(1)


def readings():
    for s in range(seconds):
        at = begin_ns + s * SECOND_NS
        yield first + s, device, at, at, s


def values():
    for s in range(seconds):
        wave = 21 + 0.4 * math.sin(s / 5000)
        for i, (channel, _) in enumerate(channels):
            yield first + s, channel, wave + 0.05 * i + random.gauss(0, 0.002)


database.executemany("INSERT INTO reading (reading_id, device_id, start_ns, end_ns, sequence) VALUES (?, ?, ?, ?, ?)", readings())
database.executemany("INSERT INTO reading_value (reading_id, channel_id, value) VALUES (?, ?, ?)", values())
database.execute("UPDATE run_progress SET started_ns = ? WHERE run_id = 1", (begin_ns,))
database.execute("UPDATE run SET created_ns = ? WHERE run_id = 1", (begin_ns,))
database.commit()
print(",".join(name for _, name in channels))
