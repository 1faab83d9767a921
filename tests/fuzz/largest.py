#!/usr/bin/env python3
"""Inputs of one size, as large as a door lets through: made of a target's seeds, repeated and changed in some hundred places.

largest.py TARGET BYTES COUNT [SEED_FOLDER...]
The target reads them one after another, each within a minute. Exit code 1: one of them failed; it is kept beside the
temporary files and named.
"""
import pathlib
import random
import shutil
import subprocess
import sys
import tempfile

BATCH_BYTES = 256 << 20  # on the disk at a time


def main():
    target, size, count = sys.argv[1], int(sys.argv[2]), int(sys.argv[3])
    seeds = [path.read_bytes() for folder in sys.argv[4:] for path in sorted(pathlib.Path(folder).iterdir()) if path.is_file()]
    seeds = [one for one in seeds if one] or [b"0"]
    draw = random.Random(20261121)
    made = 0
    while made < count:
        with tempfile.TemporaryDirectory(prefix="driftwise-fuzz-") as folder:
            paths = []
            for _ in range(min(count - made, max(1, BATCH_BYTES // size))):
                kind = draw.randrange(4)
                seed = draw.choice(seeds)
                # The whole seed again and again; its end again and again; many bytes of one kind; noise.
                tail = seed[draw.randrange(len(seed)):] or seed
                text = {0: seed * (size // len(seed) + 1), 1: seed + tail * (size // len(tail) + 1),
                        2: seed + bytes([draw.choice(b"0[{(,;\n \"\\9-")]) * size, 3: seed + draw.randbytes(min(size, 1 << 20)) * (size // (1 << 20) + 1)}[kind]
                body = bytearray(text[:size])
                for _ in range(draw.randrange(300)):
                    body[draw.randrange(size)] = draw.randrange(256)
                path = pathlib.Path(folder, "%05d" % (made + len(paths)))
                path.write_bytes(body)
                paths.append(path)
            done = subprocess.run([target, "-timeout=60", "-rss_limit_mb=4096", "-artifact_prefix=" + folder + "/", *map(str, paths)],
                                  stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, errors="replace")
            if done.returncode != 0:
                print(done.stdout[-4000:])
                kept = tempfile.mkdtemp(prefix="driftwise-fuzz-failed-")
                for path in pathlib.Path(folder).iterdir():
                    if path.name in done.stdout or path.name.startswith(("crash", "timeout", "oom")):
                        shutil.copy(path, kept)
                print("failed: the inputs named above are in " + kept)
                return 1
            made += len(paths)
    print("%d inputs of %d bytes" % (made, size))
    return 0


if __name__ == "__main__":
    sys.exit(main())
