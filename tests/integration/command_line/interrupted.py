#!/usr/bin/python3
"""Commands of files alone end at the first signal, with 130.

Usage: interrupted.py path/to/driftwise path/to/source
"""
import signal
import subprocess
import sys


def main():
    program = sys.argv[1]
    bad = 0
    verbs = {
        "diagnose": ["diagnose", "-", "--baseline", "q ~ x"],
        "fit": ["fit", "-", "--model", "q ~ x"],
    }
    for verb, arguments in verbs.items():
        for number in (signal.SIGINT, signal.SIGTERM):
            running = subprocess.Popen([program, *arguments], stdin=subprocess.PIPE, stdout=subprocess.PIPE,
                                       stderr=subprocess.PIPE)
            # More than a pipe holds: when it is written the program reads, and waits for the rest.
            running.stdin.write(b"q1_mm,x_mm\n" + b"0.5,0.5\n" * 100_000)
            running.stdin.flush()
            running.send_signal(number)
            try:
                code = running.wait(timeout=60)
            except subprocess.TimeoutExpired:
                running.kill()
                running.wait()
                code = "none within 60 s"
            running.stdout.close()
            running.stderr.close()
            try:
                running.stdin.close()
            except BrokenPipeError:
                pass
            if code != 130:
                bad += 1
                print(f"{verb}, {signal.Signals(number).name}: exit code {code}, expected 130")
    return 1 if bad else 0


if __name__ == "__main__":
    sys.exit(main())
