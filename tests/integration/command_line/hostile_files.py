#!/usr/bin/python3
"""Files that are no tables, on the command line: each ends with exit code 3 and a sentence, within seconds and little memory.

Usage: hostile_files.py path/to/driftwise path/to/source
"""
import os
import resource
import subprocess
import sys
import tempfile
import time

MOST_MEMORY = 512 << 20
MOST_SECONDS = 20


def limited():
    resource.setrlimit(resource.RLIMIT_DATA, (MOST_MEMORY, MOST_MEMORY))
    resource.setrlimit(resource.RLIMIT_CORE, (0, 0))


def main():
    program = sys.argv[1]
    bad = 0
    with tempfile.TemporaryDirectory() as scratch:
        def written(name, text):
            path = os.path.join(scratch, name)
            with open(path, "wb") as file:
                file.write(text)
            return path

        wide = b"time_s," + b",".join(b"c%d_mm" % i for i in range(300_000)) + b"\n" + b"," * 300_000 + b"\n"
        sparse = written("sparse.csv", b"")
        os.truncate(sparse, 1 << 40)
        cases = [
            ("a device without an end", "/dev/zero", "NOT_TEXT", None),
            ("noise", "/dev/urandom", None, None),
            ("memory of a process", "/proc/self/mem", "CANNOT_READ", None),
            ("300 000 columns", written("wide.csv", wide), "TOO_MANY_COLUMNS", None),
            ("a terabyte of nothing", sparse, "NOT_TEXT", None),
            ("an empty device", "/dev/null", "EMPTY_FILE", None),
            ("a folder", scratch, "NOT_A_FILE", None),
            ("a line without an end", written("line.csv", b"x" * (8 << 20)), "HEADER_TOO_LONG", None),
            ("escape sequences", written("escape.csv", b"time_s,\x1b]0;pwned\x07q1_mm\n1,2\n"), "NO_HEADER", None),
            ("a pipe without an end", "-", "HEADER_TOO_LONG", b"x" * (4 << 20)),
        ]
        for verb in ("fit", "diagnose"):
            for name, path, reason, given in cases:
                arguments = [program, verb, path, "--json"]
                arguments += ["--model" if verb == "fit" else "--baseline", "q ~ x"]
                begin = time.monotonic()
                try:
                    done = subprocess.run(arguments, input=given, capture_output=True, preexec_fn=limited,
                                          timeout=60, check=False)
                except subprocess.TimeoutExpired:
                    bad += 1
                    print(f"{verb}, {name}: no end within 60 s")
                    continue
                took = time.monotonic() - begin
                said = done.stderr.decode(errors="replace")
                good = (done.returncode == 3 and (reason is None or reason in said) and took < MOST_SECONDS
                        and "\x1b" not in said)
                if not good:
                    bad += 1
                    print(f"{verb}, {name}: exit {done.returncode} after {took:.1f} s: {said[:400]}")
    print("all refused" if bad == 0 else f"{bad} of {2 * len(cases)} wrong")
    return 1 if bad else 0


if __name__ == "__main__":
    sys.exit(main())
