#!/usr/bin/python3
"""A record that is written anew: a row is changed and the whole chain computed again, as docs/database.md tells how. The
record is whole in itself; the head that a backup left beside it shows the change.

Usage: rewritten_record.py BIN SOURCE
"""
import glob
import hashlib
import os
import re
import sqlite3
import sys
import zlib

from cell import SOURCE, Cell, check, run

TEXT = open(os.path.join(SOURCE, "clients/examples/python/check_chain.py"), encoding="utf-8").read()
chain = {}
exec(compile(TEXT.rsplit("\nmain()", 1)[0], "check_chain.py", "exec"), chain)  # its bytes, without its main()


def compute_anew(path):
    """The chain of a record as it is: its layouts, then every unit, then the heads."""
    record, integer, encoded = chain["Record"](path), chain["integer"], chain["encoded"]
    entries = []
    for kind, (key, tables) in chain["KINDS"].items():
        entries.append(("layout", record.layout(kind).encode()))
        units = {}
        for place, table in enumerate(tables):
            columns, rest = record.tables[table]
            for row in record.db.execute(
                    f"SELECT {', '.join(key + rest + columns)} FROM {table} ORDER BY {', '.join(key + rest)}"):
                name = b"".join(encoded(value) for value in row[:len(key)])
                after = b"".join(encoded(value) for value in row[len(key):len(key) + len(rest)])
                text = integer(place) + b"".join(encoded(value) for value in row[len(key) + len(rest):])
                units.setdefault((tuple(v if isinstance(v, int) else v.bytes for v in row[:len(key)]), name), []).append(
                    (place, after, text))
        for (_, name), rows in sorted(units.items(), key=lambda one: one[0][0]):
            digest = hashlib.sha256(integer(kind) + name + b"".join(text for _, _, text in rows)).digest()
            data = integer(kind) + name + digest + integer(len(rows))
            for place, after, text in rows:
                data += integer(place) + after + (zlib.crc32(text) & 0xFFFFFFFF).to_bytes(4, "big")
            entries.append(("begin", data))
    record.db.close()
    head = bytes(32)
    with sqlite3.connect(path) as database:
        database.execute("DELETE FROM chain")
        for number, (what, data) in enumerate(entries, 1):
            head = hashlib.sha256(head + integer(number) + encoded(chain["Text"](what.encode())) + data).digest()
            database.execute("INSERT INTO chain (entry_id, what, bytes, head) VALUES (?, ?, ?, ?)", (number, what, data, head))
    database.close()
    return head.hex(), len(entries)


def main():
    with Cell(access=False) as cell:
        plan = cell.path("plan.csv")
        with open(plan, "w", encoding="ascii") as file:
            file.write("q1_mm\n0\n0.1\n0.2\n")
        number = cell.ask("run", "start", plan)["id"]
        cell.cli("run", "watch", str(number), "--timeout", "100")
        copy = cell.ask("backup")
        heads = glob.glob(copy["path"] + "*head*") or glob.glob(os.path.splitext(copy["path"])[0] + "*head*")
        check(len(heads) == 1, "the backup has its head beside it")
        kept = re.search(r"[0-9a-f]{64}@\d+", open(heads[0], encoding="ascii").read()).group()
        check(kept == "%s@%s" % (copy["head"]["hash"], copy["head"]["entry"]), "which is the one that was printed")
        cell.stop()

        path = cell.database()
        code, said = cell.verify("--head", kept)
        check(code == 0, "the record holds the kept head: " + said.strip().splitlines()[0])
        with sqlite3.connect(path) as database:
            database.execute("UPDATE point_value SET value = value + 0.001 WHERE point_id = 2 AND value IS NOT NULL")
        database.close()
        code, said = cell.verify()
        check(code == 1 and "point_value with point_id 2" in said, "a changed row is named")
        head, entries = compute_anew(path)
        code, said = cell.verify()
        check(code == 0 and head in said, f"a chain computed anew, of {entries} entries, is whole in itself: {said[:200]}")
        check(run("/usr/bin/python3", SOURCE + "/clients/examples/python/check_chain.py", path).returncode == 0,
              "the checker of another hand is content too")
        for none in (path + ".missing", __file__):
            checked = run("/usr/bin/python3", SOURCE + "/clients/examples/python/check_chain.py", none)
            check(checked.returncode == 2 and "cannot be read as a record" in checked.stderr, "what is no record is not called changed: " + none)
        code, said = cell.verify("--head", kept)
        check(code == 1 and ("written anew" in said or "is missing" in said), "the head of the backup finds it: " + said.strip())
        # The same at an entry that the new chain has: padded to more entries than the old one.
        number = int(kept.split("@")[1])
        while entries < number:
            cell.sql("INSERT INTO channel (name) SELECT 'f' || hex(randomblob(6)) || '_mm' FROM "
                     "(WITH RECURSIVE n(i) AS (SELECT 1 UNION ALL SELECT i + 1 FROM n WHERE i < %d) SELECT i FROM n)"
                     % (number - entries + 5))
            head, entries = compute_anew(path)
        code, said = cell.verify()
        check(code == 0, "longer, it is whole in itself as well: " + said[:200])
        code, said = cell.verify("--head", kept)
        check(code == 1 and "was written anew" in said, "and the head finds it")
    return 0


if __name__ == "__main__":
    sys.exit(main())
