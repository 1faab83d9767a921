"""`driftwise fit` run as a person runs it: a CSV written, the program started, its JSON or its complaint read."""
import json
import os
import subprocess

BIG = ["--blocks", "0"]


def write_csv(path, names, rows, extra=()):
    """names: symbols without a unit; numbers are written so that they read back exactly."""
    with open(path, "w", encoding="ascii") as file:
        file.write(",".join(list(extra) + [name + "_1" for name in names]) + "\n")
        for row in rows:
            file.write(",".join(value if isinstance(value, str) else repr(value) for value in row) + "\n")


def run(program, path, formula, *options):
    return subprocess.run([program, "fit", path, "--model", formula, *options], capture_output=True, text=True,
                          env={**os.environ, "LC_ALL": "C"}, check=False)


def fit(program, path, formula, *options):
    done = run(program, path, formula, *options, "--json")
    if done.returncode != 0:
        raise AssertionError(f"{formula}: exit {done.returncode}: {done.stderr}")
    return json.loads(done.stdout)


def steps(output):
    return [("+" if step["action"] == "enter" else "-") + step["term"]
            for step in output["history"] if step["action"] != "start"]
