#!/usr/bin/python3
"""--residuals: what the file holds is the data less the model, and gives the figures of the page.

Usage: residuals.py path/to/driftwise path/to/source
"""
import csv
import math
import os
import sys
import tempfile

import any_number_of_threads
import fit_of_file


def main():
    program = sys.argv[1]
    with tempfile.TemporaryDirectory() as scratch:
        data, written = os.path.join(scratch, "data.csv"), os.path.join(scratch, "residuals.csv")
        any_number_of_threads.campaign(data, 300)
        result = fit_of_file.fit(program, data, "q ~ x + x^2 + y + x:y + t01 + t02", "--residuals", written)
        with open(written, encoding="ascii") as file:
            rows = list(csv.DictReader(line for line in file if not line.startswith("#")))
        assert len(rows) == 300
        for output in ("q1", "q2"):
            figures = result["outputs"][output]
            residuals = [float(row[output + "_residual_nm"]) for row in rows]
            by_hand = [1e6 * (float(row[output + "_mm"]) - float(row[output + "_model_mm"])) for row in rows]
            assert max(abs(a - b) for a, b in zip(residuals, by_hand)) < 1e-9
            rmse = math.sqrt(sum(r * r for r in residuals) / figures["dof"])
            # rounding of mm: 4 mm x 2e-16 is 1e-3 pm
            assert abs(rmse - figures["rmse_nm"]) < 1e-6 * rmse, (rmse, figures["rmse_nm"])
            inside = [term for term in figures["terms"] if term["in"]]
            assert len(figures["covariance"]) == len(inside)
            for i, term in enumerate(inside):
                assert math.isclose(math.sqrt(figures["covariance"][i][i]), term["standard_error"], rel_tol=1e-9)
            print(f"{output}: {rmse:.4f} nm from the file, {figures['rmse_nm']:.4f} nm on the page")
    return 0


if __name__ == "__main__":
    sys.exit(main())
