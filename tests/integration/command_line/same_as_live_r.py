#!/usr/bin/python3
"""Random problems made and solved by R here and now, then by `driftwise fit`: path, terms and statistics to 1e-6.

Usage: same_as_live_r.py path/to/driftwise path/to/source [seed] [problems]
Without a seed the day's date is one, so that every day asks new questions; it is printed. Exit code 77: no Rscript here.
"""
import datetime
import os
import shutil
import subprocess
import sys
import tempfile

import fit_of_file


def problems(text):
    lines = iter(text.splitlines())
    for line in lines:
        word, number, kind, rows, columns, enter, remove, weighted = line.split()
        assert word == "problem"
        rows, columns = int(rows), int(columns)
        data = [next(lines).split() for _ in range(rows)]
        path = next(lines).split()[1:]
        rmse, dof = next(lines).split()[1:]
        terms = [[float(value) for value in next(lines).split()] for _ in range(columns + 1)]
        yield dict(number=number, kind=kind, columns=columns, enter=enter, remove=remove, weighted=weighted == "1",
                   data=data, path=path, rmse=float(rmse), dof=int(dof), terms=terms)


def near(value, golden, scale):
    return abs(value - golden) <= 1e-6 * (abs(golden) + scale)


def complaints(program, scratch, problem):
    names = ["y"] + [f"x{j}" for j in range(1, problem["columns"] + 1)] + (["w"] if problem["weighted"] else [])
    path = os.path.join(scratch, "problem.csv")
    fit_of_file.write_csv(path, names, problem["data"])
    options = ["--p-enter", problem["enter"], "--p-remove", problem["remove"], "--blocks", "0"]
    if problem["weighted"]:
        options += ["--weights", "w"]
    formula = "y ~ " + " + ".join(f"x{j}" for j in range(1, problem["columns"] + 1))
    output = fit_of_file.fit(program, path, formula, *options)["outputs"]["y"]
    seen = [step.replace("x", "") for step in fit_of_file.steps(output)]
    if seen != problem["path"]:
        yield f"path {seen}, R took {problem['path']}"
        return
    if output["dof"] != problem["dof"] or not near(output["rmse_1"], problem["rmse"], 0):
        yield f"rmse {output['rmse_1']} with {output['dof']} dof, R found {problem['rmse']} with {problem['dof']}"
    for term, (state, coefficient, error, t, p) in zip(output["terms"], problem["terms"]):
        if term["in"] != (state == 1):
            yield f"{term['term']} is {'in' if term['in'] else 'out'}"
        if state < 0:
            if "note" not in term:
                yield f"{term['term']} cannot be tried and does not say why"
            continue
        # A coefficient far below its standard error agrees to 1e-6 of that: see stepwise_golden_test.cc.
        if not (near(term["coefficient"], coefficient, error) and near(term["standard_error"], error, 0) and
                near(term["t"], t, 1)):
            yield f"{term['term']}: {term['coefficient']} +- {term['standard_error']}, R: {coefficient} +- {error}"
        if p > 1e-280 and abs(term["p"] / p - 1) > 1e-6 * (1 + t * t):
            yield f"{term['term']}: p {term['p']}, R: {p}"


def main():
    program, source = sys.argv[1:3]
    seed = sys.argv[3] if len(sys.argv) > 3 else datetime.date.today().strftime("%Y%m%d")
    count = sys.argv[4] if len(sys.argv) > 4 else "36"
    if shutil.which("Rscript") is None:
        print("SKIPPED: Rscript is not installed; the stored golden results are checked by unit_calibration",
              file=sys.stderr)
        return 77
    script = os.path.join(source, "tests", "data", "stepwise_golden", "make_golden.R")
    text = subprocess.run(["Rscript", script, seed, count], capture_output=True, text=True, check=True).stdout
    kinds, bad = {}, 0
    with tempfile.TemporaryDirectory() as scratch:
        for problem in problems(text):
            kinds[problem["kind"]] = kinds.get(problem["kind"], 0) + 1
            for complaint in complaints(program, scratch, problem):
                bad += 1
                print(f"problem {problem['number']} ({problem['kind']}): {complaint}")
    listed = ", ".join(f"{kind} {number}" for kind, number in sorted(kinds.items()))
    print(f"seed {seed}: {sum(kinds.values())} problems ({listed}), {bad} disagreements")
    return 0 if bad == 0 and sum(kinds.values()) == int(count) else 1


if __name__ == "__main__":
    sys.exit(main())
