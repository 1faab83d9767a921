#!/usr/bin/python3
"""The same model to the last digit from 1, 2, 3 and 8 threads, small and large, with several starts and blocks.

Usage: any_number_of_threads.py path/to/driftwise path/to/source
"""
import math
import os
import random
import sys
import tempfile

import fit_of_file


def campaign(path, rows):
    random.seed(rows)
    drift = [0.0, 0.0, 0.0]
    with open(path, "w", encoding="ascii") as file:
        file.write("time_s,q1_mm,q2_mm,x_mm,y_mm,t01_degC,t02_degC,t03_degC\n")
        for i in range(rows):
            x, y = -4 + 0.5 * (i % 17), -2 + 0.5 * (i // 17 % 9)
            drift = [0.99 * d + 0.01 * random.gauss(0, 1) for d in drift]
            t = [21 + 0.3 * math.sin(i / (150 + 60 * k)) + d for k, d in enumerate(drift)]
            q1 = x + 2e-5 * x * x + 4e-4 * t[0] + 3e-6 * random.gauss(0, 1)
            q2 = y - 1e-5 * x * y - 2e-4 * t[1] + 3e-6 * random.gauss(0, 1)
            file.write(",".join(repr(v) for v in (14.3 * i, q1, q2, x, y, *t)) + "\n")


def main():
    program = sys.argv[1]
    with tempfile.TemporaryDirectory() as scratch:
        path = os.path.join(scratch, "data.csv")
        for rows, options in [(560, ("--starts", "6")), (560, ("--criterion", "bic", "--hierarchy")), (40000, ())]:
            campaign(path, rows)
            results = []
            for threads in ("1", "2", "3", "8"):
                result = fit_of_file.fit(program, path, "q ~ poly(x, y, 3) + T + x:T", "--threads", threads, *options)
                result["fit_us"] = 0
                results.append(result)
            if any(result != results[0] for result in results):
                print(f"{rows} rows {' '.join(options)}: the models differ")
                return 1
            terms = sum(term["in"] for term in results[0]["outputs"]["q1"]["terms"])
            print(f"{rows} rows {' '.join(options)}: the same {terms} terms and every digit on 1, 2, 3 and 8 threads")
    return 0


if __name__ == "__main__":
    sys.exit(main())
