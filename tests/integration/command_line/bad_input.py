#!/usr/bin/python3
"""What a person gets wrong in a fit: every case ends with exit code 3 and a sentence that says what and where.

Usage: bad_input.py path/to/driftwise path/to/source
"""
import os
import sys
import tempfile

import fit_of_file

ROWS = [(i, 0.1 * i, 20 + 0.01 * (i % 7), 3.0) for i in range(30)]  # y's place, x, t01, t02


def table(header, rows):
    return header + "\n" + "\n".join(",".join(str(value) for value in row) for row in rows) + "\n"


def measured(rows=ROWS, header="q1_mm,x_mm,t01_degC,t02_degC"):
    return table(header, [(repr(1 + 2 * x + 0.001 * ((i * 7919) % 13) + 0.01 * t), repr(x), repr(t), repr(u))
                          for i, x, t, u in rows])


def with_set(rows, copies):
    lines = measured().splitlines()
    text = ["set," + lines[0]] + [("validation," if i % 3 == 0 else "calibration,") + line
                                  for i, line in enumerate(lines[1:])]
    return "\n".join(text + ["validation," + lines[copies]]) + "\n"


ALL = ("--select", "all")
# name, file, formula, options, exit code, what the sentence or the page must say
CASES = [
    ("too few rows", measured(ROWS[:3]), "q1 ~ x + x^2 + t01", ALL, 3,
     ["TOO_FEW_ROWS", "3 complete calibration rows", "at least 5"]),
    ("no rows", "q1_mm,x_mm\n", "q1 ~ x", (), 3, ["NO_ROWS"]),
    ("a constant column", measured(), "q1 ~ x + t02", ALL, 3, ["RANK_DEFICIENT", "t02 is constant at 3"]),
    ("a nearly constant thermometer",
     measured([(i, x, t, 21 + 1e-4 * (-1) ** i) for i, x, t, _ in ROWS]), "q1 ~ x + t02", ALL, 0,
     ["t02 is constant within 0.2 mK"]),
    ("a column twice in values", table("q1_mm,x_mm,y_mm", [(1 + x + 0.01 * (i % 5), x, x) for i, x, _, _ in ROWS]),
     "q1 ~ x + y", ALL, 3, ["RANK_DEFICIENT", "x and y cannot be told apart on these rows"]),
    ("squares on a symmetric grid",
     table("q1_mm,x_mm,y_mm", [(i + 0.1 * (i % 3), (-1) ** i, (-1) ** (i // 2)) for i in range(12)]),
     "q1 ~ x + y + x^2", ALL, 3, ["RANK_DEFICIENT", "x^2 is constant on these rows"]),
    ("a column twice by name", "q1_mm,x_mm,x_mm\n1,2,3\n", "q1 ~ x", (), 3, ["DUPLICATE_COLUMN", "x_mm"]),
    ("one symbol in two units", "q1_mm,x_mm,x_um\n1,2,3\n", "q1 ~ x", (), 3,
     ["UNITS_DISAGREE", "x_um", "x_mm", "column 3", ":1:"]),
    ("no unit", "q1_mm,x\n1,2\n", "q1 ~ x", (), 3, ["BAD_CHANNEL", "column 2"]),
    ("an infinity", measured().replace("20.03", "inf", 1), "q1 ~ x + t01", (), 3, ["BAD_NUMBER", "t01_degC", "inf"]),
    ("not a number", measured().replace("20.03", "nan", 1), "q1 ~ x + t01", (), 3, ["BAD_NUMBER", "t01_degC"]),
    ("missing values", measured().replace(",20.03,", ",,"), "q1 ~ x + t01", (), 0, ["4 rows dropped for missing values"]),
    ("nothing but missing values", table("q1_mm,x_mm", [(i, "") for i in range(9)]), "q1 ~ x", (), 3,
     ["TOO_FEW_ROWS", "0 complete calibration rows (9 dropped for missing values)"]),
    ("an unknown channel", measured(), "q1 ~ x + t1", (), 3, ["UNKNOWN_CHANNEL", "'t1'", "did you mean t01?", "^"]),
    ("an unknown output", measured(), "q3 ~ x", (), 3, ["UNKNOWN_CHANNEL", "'q3'", "did you mean q1?"]),
    ("an unknown channel of weights", measured(), "q1 ~ x", ("--weights", "w"), 3, ["UNKNOWN_CHANNEL", "'w'"]),
    ("an unknown channel left out", measured(), "q1 ~ x", ("--exclude", "t09"), 3, ["UNKNOWN_CHANNEL", "'t09'"]),
    ("sets that overlap", with_set(ROWS, 5), "q1 ~ x + t01", (), 3,
     ["SETS_OVERLAP", "1 of 11 validation rows", "row 31 is row 5"]),
    ("thresholds that cycle", measured(), "q1 ~ x", ("--p-enter", "0.2", "--p-remove", "0.1"), 3,
     ["BAD_OPTIONS", "p_remove 0.1 is below p_enter 0.2"]),
    ("a parent that is not offered", measured(), "q1 ~ t01", ("--hierarchy", "--force", "x:t01"), 3,
     ["BAD_OPTIONS", "its parent x is not offered"]),
    ("an output among its terms", measured(), "q1 ~ x + q1^2", (), 3, ["BAD_FORMULA", "q1"]),
]


def main():
    program = sys.argv[1]
    bad = 0
    with tempfile.TemporaryDirectory() as scratch:
        path = os.path.join(scratch, "data.csv")

        def check(name, formula, options, exit_code, wanted):
            nonlocal bad
            done = fit_of_file.run(program, path, formula, *options, "--json")
            said = done.stdout + done.stderr
            missing = [text for text in wanted if text not in said]
            if done.returncode != exit_code or missing:
                bad += 1
                print(f"{name}: exit {done.returncode}, expected {exit_code}; lacks {missing}; said: {said[:600]}")

        for name, text, formula, options, exit_code, wanted in CASES:
            with open(path, "w", encoding="ascii") as file:
                file.write(text)
            check(name, formula, options, exit_code, wanted)
        with open(path, "w", encoding="ascii") as file:
            file.write(measured())
        long = os.path.join(scratch, "formula.txt")
        with open(long, "w", encoding="ascii") as file:
            file.write("q1 ~ " + " + ".join(f"x^{i % 20 + 1}:t01^{i // 20 % 20 + 1}:t02^{i // 400 % 20 + 1}"
                                            for i in range(100000)) + "\n")
        check("a formula of 100 000 terms", "@" + long, (), 3, ["FORMULA_TOO_LARGE"])
        check("a formula that unfolds", "q1 ~ " + "*".join(["(1 + x + t01 + t02)"] * 12), (), 3, ["FORMULA_TOO_LARGE"])
    print(f"{len(CASES) + 2} kinds of bad input, {bad} without their sentence")
    return 0 if bad == 0 else 1


if __name__ == "__main__":
    sys.exit(main())
