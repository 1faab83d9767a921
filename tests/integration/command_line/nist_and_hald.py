#!/usr/bin/python3
"""Certified data through the public command line.

Usage: nist_and_hald.py path/to/driftwise path/to/source
NIST StRD, linear least squares: correct digits of every coefficient and standard error, worst of each set, against what
is promised; then Hald's cement data along its two published paths. Digits are counted in decimal arithmetic from the
text that the program prints. Exit code 1 when a promise is not kept.
"""
import csv
import decimal
import os
import sys
import tempfile

import fit_of_file

D = decimal.Decimal
QUINTIC = "y ~ x + x^2 + x^3 + x^4 + x^5"
SETS = [("Longley", "y ~ x1 + x2 + x3 + x4 + x5 + x6", 13), ("Filip", "y ~ poly(x, 10)", 13), ("Norris", "y ~ x", 12),
        ("Pontius", "y ~ x + x^2", 12), ("Wampler1", QUINTIC, 9), ("Wampler2", QUINTIC, 9), ("Wampler3", QUINTIC, 9),
        ("Wampler4", QUINTIC, 7), ("Wampler5", QUINTIC, 6), ("NoInt1", "y ~ x - 1", 12), ("NoInt2", "y ~ x - 1", 12)]


def rows_of(path):
    with open(path, encoding="utf-8") as file:
        return [row for row in csv.reader(line for line in file if line.strip() and not line.startswith("#"))]


def with_units(source, target):
    """The same numbers, character by character, under names with the unit none."""
    rows = rows_of(source)
    with open(target, "w", encoding="ascii") as file:
        file.write(",".join(name + "_1" for name in rows[0]) + "\n")
        for row in rows[1:]:
            file.write(",".join(row) + "\n")
    return target


def digits(text, certified):
    """-log10 of the relative error, at most 16."""
    value = D(text)
    error = abs(value) if certified == 0 else abs((value - certified) / certified)
    return D(16) if error < D("1e-16") else -error.log10()


def nist(program, folder, scratch):
    kept = True
    print("set        promised  coefficients  standard errors")
    for name, formula, promised in SETS:
        path = with_units(os.path.join(folder, name + ".csv"), os.path.join(scratch, name + ".csv"))
        result = fit_of_file.fit(program, path, formula, "--select", "all", "--blocks", "0")
        terms = result["outputs"]["y"]["terms"]
        certified = [(D(row[1]), D(row[2])) for row in rows_of(os.path.join(folder, name + "_certified.csv"))
                     if row[0].startswith("b")]
        assert len(terms) == len(certified), name
        worst, worst_error, exact = D(16), D(16), D(0)
        for term, (estimate, error) in zip(terms, certified):
            worst = min(worst, digits(repr(term["coefficient"]), estimate))
            if error == 0:
                exact = max(exact, D(repr(term["standard_error"])) / abs(estimate))
            else:
                worst_error = min(worst_error, digits(repr(term["standard_error"]), error))
        is_exact = all(error == 0 for _, error in certified)
        good = worst >= promised and (exact <= D("1e-7") if is_exact else worst_error >= promised)
        kept = kept and good
        errors = f"at most {exact:.1e} |b|" if is_exact else f"{worst_error:.1f}"
        print(f"{name:10} {promised:8}  {worst:12.1f}  {errors:15}  {'' if good else 'NOT MET'}")
    return kept


def hald(program, folder, scratch):
    path = with_units(os.path.join(folder, "hald.csv"), os.path.join(scratch, "hald.csv"))
    expected = rows_of(os.path.join(folder, "hald_expected.csv"))
    kept = True
    for p_enter, path_wanted, model in [("0.05", ["+x4", "+x1"], "x1+x4"), ("0.06", ["+x4", "+x1", "+x2", "-x4"], "x1+x2")]:
        output = fit_of_file.fit(program, path, "heat ~ x1 + x2 + x3 + x4", "--p-enter", p_enter, "--p-remove", "0.10",
                                 "--blocks", "0")["outputs"]["heat"]
        seen = fit_of_file.steps(output)
        terms = {term["term"]: term for term in output["terms"]}
        worst = D(16)
        for row in expected:
            if row[0] != model or row[1] == "rmse":
                continue
            inside = not row[1].startswith("(")
            term = terms["1" if row[1] == "const" else row[1] if inside else row[1][1:3]]
            kept = kept and term["in"] == inside
            for key, text in zip(["coefficient", "standard_error", "t"], row[2:5]):
                worst = min(worst, digits(repr(term[key]), D(text)))
        good = seen == path_wanted and worst >= D("5.9")  # the file gives 8 digits of terms left out
        kept = kept and good
        print(f"Hald, enter below {p_enter}: {' '.join(seen)}; {worst:.1f} digits of every term {'' if good else 'NOT MET'}")
    return kept


def main():
    program, source = sys.argv[1:3]
    folder = os.path.join(source, "tests", "data", "nist_strd")
    with tempfile.TemporaryDirectory() as scratch:
        kept = [nist(program, folder, scratch), hald(program, folder, scratch)]
    return 0 if all(kept) else 1


if __name__ == "__main__":
    sys.exit(main())
