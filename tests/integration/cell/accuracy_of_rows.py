#!/usr/bin/env python3
"""Accuracy figures from exported rows, by nothing but the definitions of docs/fitting.md.

accuracy_of_rows.py residuals FILE   columns <output>_held_out_<unit>, per set: validation, blocks
accuracy_of_rows.py targets FILE     columns <coordinate>_target_mm less <coordinate>_mm, zero = 0

Prints JSON: {"figures": [{"output", "rows", "unit", "count", "mean", "u90", "a90"}], "heading": [...]}.
The heading has the largest a90 of every unit. Shares no code with Driftwise.
"""
import csv
import json
import math
import sys


def rows_of(path):
    with open(path, newline="") as file:
        return list(csv.DictReader(line for line in file if not line.startswith("#")))


def figures_of(errors):
    count = len(errors)
    mean = math.fsum(errors) / count
    spread = math.sqrt(math.fsum((e - mean) ** 2 for e in errors) / (count - 1))
    rms = math.sqrt(math.fsum(e * e for e in errors) / count)
    return {"count": count, "mean": mean, "u90": 1.645 * spread, "a90": 1.645 * rms}


def of_residuals(rows):
    figures = []
    for column in rows[0]:
        if "_held_out_" not in column:
            continue
        output, unit = column.split("_held_out_")
        for kept, name in (("validation", "validation"), ("calibration", "blocks")):
            errors = [
                float(row[column])
                for row in rows
                if row.get("set", "calibration") == kept and row[column] != ""
            ]
            if len(errors) >= 2:
                figures.append({"output": output, "rows": name, "unit": unit, **figures_of(errors)})
    return figures


def of_targets(rows):
    figures = []
    for column in rows[0]:
        if not column.endswith("_target_mm"):
            continue
        coordinate = column[: -len("_target_mm")]
        errors = [
            1e6 * (float(row[column]) - float(row[coordinate + "_mm"]))
            for row in rows
            if row.get("zero", "0") == "0" and row[column] != "" and row[coordinate + "_mm"] != ""
        ]
        figures.append({"output": coordinate, "rows": "fresh", "unit": "nm", **figures_of(errors)})
    return figures


def main():
    if len(sys.argv) != 3 or sys.argv[1] not in ("residuals", "targets"):
        sys.exit(__doc__)
    rows = rows_of(sys.argv[2])
    figures = of_residuals(rows) if sys.argv[1] == "residuals" else of_targets(rows)
    heading = {}
    for one in figures:
        if one["unit"] not in heading or one["a90"] > heading[one["unit"]]["a90"]:
            heading[one["unit"]] = one
    print(json.dumps({"figures": figures, "heading": list(heading.values())}))


main()
