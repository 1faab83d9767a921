#!/usr/bin/env python3
"""Checks the chain of a Driftwise record, with Python's standard library alone.

    check_chain.py cell.db            prints HASH@N, or what differs; exit code 1: something does
                                      before it, a line for each stretch of readings that was thinned
                                      exit code 2: a record that this program cannot judge, or no record

The record may be at work: everything is read in one transaction. Which tables it has is told by the chain's own
layout entries, so records of older schemas are checked too; tables that are newer than this program end it with 2.

Written from docs/database.md, "The chain": it shares no code with the daemon.
"""

import hashlib
import pathlib
import re
import sqlite3
import struct
import sys

KINDS = {
    1: (["hash"], ["cell_config"]),
    2: (["start_id"], ["configuration_start"]),
    3: (["run_id"], ["run"]),
    4: (["run_id"], ["run_progress"]),
    5: (["run_id"], ["run_configuration"]),
    6: (["run_id"], ["imported_file", "imported_metadata", "imported_column"]),
    7: (["channel_id"], ["channel"]),
    8: (["device_id"], ["device"]),
    9: (["datum_id"], ["datum", "datum_value"]),
    10: (["point_id"], ["point", "point_value"]),
    11: (["attempt_id"], ["attempt"]),
    12: (["reading_id"], ["reading", "reading_value"]),
    13: (["device_id", "start_ns", "sequence"], ["rejected_value"]),
    14: (["at_ns", "ordinal"], ["move"]),
    15: (["model_id"], ["model", "model_correction"]),
    16: (["promotion_id"], ["promotion"]),
    17: (["event_id"], ["event"]),
    18: (["exclusion_id"], ["exclusion", "exclusion_row", "suspect_mark"]),
    19: (["note_id"], ["note"]),
    20: (["diagnosis_id"], ["diagnosis", "diagnosis_run"]),
    21: (["correction_id"], ["correction", "correction_change"]),
    22: (["extension_id"], ["extension", "extension_exclusion"]),
    23: (["improvement_id"], ["improvement"]),
    24: (["improvement_id", "number"], ["improvement_turn", "improvement_gain"]),
    25: (["alarm_id"], ["alarm"]),
    26: (["trajectory_id"], ["trajectory"]),
    27: (["stop_id"], ["stop"]),
    28: (["clock_id"], ["clock"]),
    29: (["one"], ["database_identity"]),
    30: (["audit_id"], ["audit"]),
    31: (["thinning_id"], ["thinning", "thinned_value"]),
    32: (["entry_id"], ["queue_entry", "queue_result"]),
    33: (["one"], ["queue_hold"]),
    34: (["run_id"], ["run_metadata", "queue_run"]),
    35: (["plan_id"], ["plan", "plan_model"]),
    36: (["plan_promotion_id"], ["plan_promotion"]),
    37: (["time_note_id"], ["time_note"]),
    38: (["closure_id"], ["closure", "closure_coordinate"]),
    39: (["point_id"], ["repeated_point"]),
    40: (["rest_id"], ["rest"]),
    41: (["indentation_id"], ["indentation"]),
    42: (["point_id"], ["passage"]),
}


READING = 12


def integer(value):
    if value == 0:
        return b"\0"
    length = 1
    while not -(1 << (8 * length - 1)) <= value < 1 << (8 * length - 1):
        length += 1
    return bytes([length]) + value.to_bytes(length, "big", signed=True)


def encoded(value):
    if value is None:
        return b"\x10"
    if isinstance(value, int):
        return integer(value)
    if isinstance(value, float):
        return b"\x11" + struct.pack(">d", value)
    if isinstance(value, bytes):  # a BLOB; texts are read as Text below
        return b"\x13" + integer(len(value)) + value
    return b"\x12" + integer(len(value.bytes)) + value.bytes


class Text:
    def __init__(self, raw):
        self.bytes = raw


class Reader:
    def __init__(self, data):
        self.data, self.at = data, 0

    def take(self, count):
        piece = self.data[self.at : self.at + count]
        if len(piece) != count:
            raise ValueError("too short")
        self.at += count
        return piece

    def integer(self):
        return int.from_bytes(self.take(self.take(1)[0]), "big", signed=True)

    def value(self):
        begin, head = self.at, self.take(1)[0]
        if head == 0x11:
            self.take(8)
        elif head in (0x12, 0x13):
            self.take(self.integer())
        elif head != 0x10:
            self.take(head)
        return self.data[begin : self.at]


class OtherSchema(Exception):
    pass


class Record:
    def __init__(self, path):
        self.db = sqlite3.connect(pathlib.Path(path).resolve().as_uri() + "?mode=ro", uri=True, isolation_level=None)
        self.db.text_factory = Text
        self.db.execute("BEGIN")  # one view of chain and tables: a daemon writes both meanwhile
        self.tables = {}
        for key, tables in KINDS.values():
            for table in tables:
                columns = [
                    (name.bytes.decode(), pk)
                    for name, pk, hidden in self.db.execute(
                        "SELECT name, pk, hidden FROM pragma_table_xinfo(?) ORDER BY cid", (table,)
                    )
                    if hidden == 0
                ]
                primary = [name for name, pk in sorted(columns, key=lambda c: c[1]) if pk > 0]
                rest = [name for name in primary if name not in key]
                if columns:  # else a table that came with a later schema
                    self.tables[table] = ([name for name, _ in columns], rest)

    def tables_of(self, kind):
        return [table for table in KINDS[kind][1] if table in self.tables]

    def layout(self, kind):
        return f"{kind}" + "".join(
            f" {table}({','.join(self.tables[table][0])})" for table in self.tables_of(kind)
        )

    # Every unit of a kind: the bytes of its key -> (digest, how many rows)
    def units(self, kind):
        key, found = KINDS[kind][0], {}
        for place, table in enumerate(self.tables_of(kind)):
            columns, rest = self.tables[table]
            order = f" ORDER BY {', '.join(rest)}" if rest else ""
            for row in self.db.execute(
                f"SELECT {', '.join(key)}, {', '.join(columns)} FROM {table}{order}"
            ):
                name = b"".join(encoded(value) for value in row[: len(key)])
                text = integer(place) + b"".join(encoded(value) for value in row[len(key) :])
                found.setdefault(name, []).append(text)
        return {
            name: hashlib.sha256(integer(kind) + name + b"".join(rows)).digest()
            for name, rows in found.items()
        }


class Thinned:
    """An entry "thinned": readings that a thinning removed, and the hash that stands for their digests."""

    def __init__(self, data):
        reader = Reader(data)
        self.thinning, kind = reader.integer(), reader.integer()
        self.count, first = reader.integer(), reader.integer()
        self.hash, blob = reader.take(32), Reader(reader.value())
        if kind != READING:
            raise ValueError("of another kind")
        blob.take(1)
        bits = blob.take(blob.integer())
        self.readings = [first + 8 * i + bit for i, byte in enumerate(bits) for bit in range(8) if byte >> bit & 1]

    # True: the digests that the chain had of these readings are those that were thinned.
    def take_from(self, digests):
        keys = [integer(reading) for reading in self.readings]
        good = len(keys) == self.count and all(digests.get(key) for key in keys)
        good = good and hashlib.sha256(b"".join(digests[key] for key in keys)).digest() == self.hash
        for key in keys:
            digests.pop(key, None)
        return good


def thinned_lines(record, stretches):
    for one in stretches:
        row = record.db.execute(
            "SELECT who, at_utc, reducer, every_ns FROM thinning WHERE thinning_id = ?", (one.thinning,)).fetchone()
        how = "" if row is None else (f" by {row[0].bytes.decode()} at {row[1].bytes.decode()}, "
                                      f"{row[2].bytes.decode()} every {row[3] // 10**9} s")
        yield (f"thinned: {one.count} readings of {one.readings[0]} to {one.readings[-1]}{how}, hash {one.hash.hex()}")


# The tables of a layout entry, in the order that its units count them by.
def tables_in(layout, kind):
    tables = re.findall(r" (\w+)\(", layout)
    if kind not in KINDS or any(table not in KINDS[kind][1] for table in tables):
        raise OtherSchema(f"record of another schema: its chain has {', '.join(tables)}, which this program does "
                          "not know; take check_chain.py of the daemon's version")
    return tables


def check(path):
    record, problems, stretches = Record(path), [], []
    head, last, newest, since, places = bytes(32), 0, {kind: {} for kind in KINDS}, {}, {}
    for entry, what, data, stored in record.db.execute(
        "SELECT entry_id, what, bytes, head FROM chain ORDER BY entry_id"
    ):
        head = hashlib.sha256(head + integer(entry) + encoded(what) + data).digest()
        if entry != last + 1 or head != stored:
            problems.append(f"entry {entry} of the chain differs")
            head = stored
        last = entry
        if what.bytes == b"layout":
            kind = int(re.match(rb"\d+", data).group())
            since[kind] = data.decode()
            newest[kind], places[kind] = {}, tables_in(since[kind], kind)
            continue
        if what.bytes == b"thinned":
            stretches.append(Thinned(data))
            if not stretches[-1].take_from(newest[READING]):
                problems.append(f"the stretch of thinning {stretches[-1].thinning} was changed before it was thinned")
            continue
        reader = Reader(data)
        while reader.at < len(data):
            kind = reader.integer()
            key = b"".join(reader.value() for _ in KINDS[kind][0])
            digest, rows = reader.take(32), reader.integer()
            for _ in range(rows):
                table = places[kind][reader.integer()]
                if table not in record.tables:
                    sys.exit(f"the record has no table {table}, whose rows its chain protects")
                for _ in record.tables[table][1]:
                    reader.value()
                reader.take(4)
            newest[kind][key] = digest if rows else None
    for kind, (_, tables) in KINDS.items():
        if kind not in since and not record.tables_of(kind):
            continue  # a schema before these tables
        if since.get(kind) != record.layout(kind):
            problems.append(f"{tables[0]}: other columns than the chain has")
        found = record.units(kind)
        for key in found.keys() | newest[kind].keys():
            expected = newest[kind].get(key)
            if found.get(key) != expected:
                state = "differs" if key in found and expected else (
                    "is missing" if expected else "is inserted")
                problems.append(f"{tables[0]} with key {key.hex()} {state}")
    return problems, list(thinned_lines(record, stretches)), f"{head.hex()}@{last}"


def main():
    if len(sys.argv) != 2:
        sys.exit(__doc__)
    try:
        problems, thinned, head = check(sys.argv[1])
    except OtherSchema as other:
        print(other, file=sys.stderr)
        sys.exit(2)
    except sqlite3.Error as unreadable:
        print(f"{sys.argv[1]}: cannot be read as a record: {unreadable}", file=sys.stderr)
        sys.exit(2)
    for line in problems + thinned:
        print(line)
    if problems:
        sys.exit(1)
    print(head)


main()
