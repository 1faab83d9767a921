#!/usr/bin/env python3
"""Bad input of several robots through the daemon and the command line, on the emulated devices of the two robots that touch. Each is
judged by exit code, reason, and a sentence that names the thing and what to do."""
import csv
import json
import os
import shutil
import sys
import tempfile
import time

import cell as outside
from cell import BIN, SOURCE, Cell, check, run, until

BAD_INPUT, REFUSED = 3, 5


def refused(cell, words, exit_code, reason, *parts):
    code, why, sentence = cell.refusal(*words)
    print(f"    {why}: {sentence}", flush=True)
    check(code == exit_code and why == reason, f"driftwise {' '.join(words[:3])}: exit {exit_code}, {reason} (found {code}, {why})")
    for part in parts:
        check(part in sentence, f"  its sentence has {part!r}")


def cell_file_checked(edits, reason, *parts):
    """`driftwised --check` and a start of the daemon on the study's cell file, changed."""
    with tempfile.TemporaryDirectory() as folder:
        file = shutil.copy(os.path.join(SOURCE, "deploy/cells/two-robots/cell.toml"), folder)
        with open(file, encoding="utf-8") as opened:
            text = opened.read()
        for found, instead in edits:
            check(found in text, f"the cell file has {found!r}")
            text = text.replace(found, instead, 1)
        with open(file, "w", encoding="utf-8") as opened:
            opened.write(text)
        for more in (["--check"], []):
            done = run(BIN + "/driftwised", "--cell", file, *more)
            said = done.stdout + done.stderr
            print("    " + said.strip().splitlines()[-1], flush=True)
            check(done.returncode not in (0, -6, -11) and reason in said, f"driftwised {' '.join(more)}: exit {done.returncode}, {reason}")
            for part in parts:
                check(part in said, f"  it says {part!r}")
        check(os.listdir(folder) == ["cell.toml"], "no file was made beside the cell file")


def cell_files():
    cell_file_checked([('id = "ma"\ncontroller', 'id = "mn"\ncontroller')], "DUPLICATE_ID", "'mn'", "robot 2")

    cell_file_checked([('[[setup]]\nname = "probe"', '[[setup]]\nname = "empty"\n\n[[setup]]\nname = "probe"')], "BAD_SETUP", "setup 2", "expected one at least")


# Lines of motor coordinates, each beginning with a return to zero.
def motor_rows(robot, rows):
    head = ",".join(f"{robot}.q{i}_mm" for i in (1, 2, 3)) + ",set,line,zero\n"
    return head + "0,0,0,calibration,1,1\n" + "".join(f"{a},{b},{c},calibration,1,0\n" for a, b, c in rows)


def measured(cell, name, text, setup):
    started = cell.ask("run", "start", cell.write(name + ".csv", text), "--setup", setup)
    number = str(started["id"])
    until("run " + number, lambda: cell.ask("run", "show", number)["run"]["state"] in ("done", "aborted", "failed", "paused"), 240)
    ended = cell.ask("run", "show", number)["run"]
    check(ended["state"] == "done", f"run {number} in set-up {setup} is done: {ended['state']} {ended['reason']}")
    return number


def setups_and_joins(cell):
    mn = cell.write("mn.csv", motor_rows("mn", [(0.5, 0.5, 0.5)]))
    refused(cell, ["run", "start", mn, "--setup", "probe"], BAD_INPUT, "NOT_MEASURED", "moves mn", "'probe'", "ma.z_mm", "Start it in a set-up")
    refused(cell, ["run", "start", mn], BAD_INPUT, "NO_SUCH_SETUP", "expected one of", "tool")
    refused(cell, ["run", "start", mn, "--setup", "prbe"], BAD_INPUT, "NO_SUCH_SETUP", "'prbe'", "probe")
    check(cell.sql("SELECT count(*) FROM run") == "0" and cell.sql("SELECT count(*) FROM move") == "0", "no run is on record, nothing moved")
    heights = [(h, h, h) for h in (0.2, 0.45, 0.1, 0.05)]
    probe = measured(cell, "heights", motor_rows("ma", heights), "probe")
    table = csv.DictReader(line for line in cell.cli("data", "export", probe).stdout.splitlines() if not line.startswith("#"))
    # The probe's friction may make the run look at its zero from aside: rows of passages, none of the plan.
    values = [row["ma.z_mm"] for row in table if row.get("passage") != "1"]
    check(len(values) == 5 and values[2] == "" and all(values[i] for i in (0, 1, 3, 4)),
          f"a probe out of its range is a state of that point, the run goes on: ma.z_mm {values}")
    refused(cell, ["fit", "--run", probe, "--model", "ma.q ~ ma.rx + ma.z"], BAD_INPUT, "UNKNOWN_CHANNEL", "ma.rx")
    level = measured(cell, "tilts", motor_rows("ma", heights[:-1] + [(0.3, 0.3, 0.3)]), "level")
    refused(cell, ["data", "join", probe, level, "--dry-run"], REFUSED, "TRAJECTORIES_DIFFER", "row 5", "join runs of one trajectory only")


def imported(cell, name, text):
    cell.ask("data", "import", cell.write(name + ".csv", text))
    return cell.sql("SELECT max(run_id) FROM run")


def fitted(cell, number, formula):
    return cell.ask("fit", "--run", number, "--model", formula)["model_id"]


def plan_models(cell):
    mn, ma = "mn.q1_mm,mn.q2_mm,mn.q3_mm,mn.x_mm,mn.y_mm,mn.z_mm,mn.rx_arcsec\n", \
        "ma.q1_mm,ma.q2_mm,ma.q3_mm,ma.rx_arcsec,ma.ry_arcsec,ma.z_mm,ma.x_mm\n"
    for i in range(64):
        a, b, c, noise = i % 4 - 1.5, i // 4 % 4 - 1.5, i // 16 - 1.5, 1e-6 * ((i * 7919) % 13 - 6)
        mn += f"{a + noise},{b - noise},{c + 2 * noise},{a},{b},{c},{10 * b + 4 * a + 1e3 * noise}\n"
        ma += f"{c + .03 * a + noise},{c - .02 * a + .02 * b},{c - .01 * a - .03 * b - noise},{100 * a},{100 * b},{c},{a + noise}\n"
    mn, ma = imported(cell, "mn_models", mn), imported(cell, "ma_models", ma)
    return {"mn": fitted(cell, mn, "mn.q ~ mn.x + mn.y + mn.z"), "tilt": fitted(cell, mn, "mn.rx ~ mn.x + mn.y + mn.z"),
            "ma": fitted(cell, ma, "ma.q ~ ma.rx + ma.ry + ma.z"), "sideways": fitted(cell, ma, "ma.x ~ ma.rx + ma.z")}


def plan(models, more="", ma=None, mn=None):
    return (f'name = "joint"\n[[robot]]\nid = "mn"\nmodel = {mn or models["mn"]}\n'
            + (ma or f'[[robot]]\nid = "ma"\nmodel = {models["ma"]}\n') + '[z]\ntaken_by = "mn"\n' + more)


# Stored, then refused at its promotion, by the check and by the command.
def plan_refused(cell, text, reason, *parts):
    done = cell.cli("plan", "add", cell.write("plan.toml", text), "--json")
    check(done.returncode == 0, "a plan is stored before it is judged " + done.stderr)
    number = str(json.loads(done.stdout)["id"])
    refused(cell, ["plan", "promote", number, "--yes"], REFUSED, reason, *parts)
    check(not any(one.get("serves") for one in cell.ask("plan", "list").get("plans", [])), "  no plan serves")


def plans(cell):
    models = plan_models(cell)
    plan_refused(cell, plan(models, f'[[parasitic]]\nmodel = {models["sideways"]}\nfrom = "ma"\nto = "mn"\nadd = ["x_mm"]\n'
                                    f'[[parasitic]]\nmodel = {models["tilt"]}\nfrom = "mn"\nto = "ma"\nadd = ["rx_arcsec"]\n'),
                 "PLAN_CYCLE", "step 2", "step 1", "ma.rx_arcsec", "mn.x_mm")
    plan_refused(cell, plan(models, ma='[[robot]]\nid = "ma"\n'
                                       f'[[blend]]\nrobot = "ma"\nfine = {models["ma"]}\ncoarse = {models["mn"]}\n'
                                       '[[blend.band]]\ncoordinates = ["rx_arcsec"]\nfrom = 300\nto = 350\n'),
                 "OTHER_ROBOT", "'mn'")
    return models


def tools(cell, models):
    """A model measured with one tool, and a plan after the tool was changed; an indentation of another tool."""
    rows = [(0.2 * (i % 3), 0.2 * (i // 3 % 3), 0.2 * ((i * 2 + i // 3) % 3)) for i in range(9)]
    number = measured(cell, "mn_tool", motor_rows("mn", rows), "tool")
    model = fitted(cell, number, "mn.q ~ mn.x + mn.y + mn.z")
    cell.stop()
    cell.edit("cell.toml", 'tool = "diamond 3"', 'tool = "diamond 4"')
    cell.start()
    done = cell.cli("configuration", "accept", "--yes", "--note", "another diamond")
    check(done.returncode == 0, "a person accepts the changed tool " + done.stderr)
    plan_refused(cell, plan(models, mn=model), "OTHER_TOOL", "diamond 3", "diamond 4")
    with open(os.path.join(SOURCE, "deploy/cells/two-robots/indentation.toml"), encoding="utf-8") as file:
        text = file.read()
    text = text.replace('by = "plan"', 'by = "geometry"\nreason = "a test without models"', 1)
    moves = cell.sql("SELECT count(*) FROM move")
    refused(cell, ["indent", "start", cell.write("other_tool.toml", text)], REFUSED, "OTHER_TOOL", "diamond 3", "diamond 4", "correct")
    check(cell.sql("SELECT count(*) FROM move") == moves, "nothing moved")
    return text.replace("diamond 3", "diamond 4")


def read_back(cell):
    values = {one["channel"]: one.get("value") for one in cell.ask("status")["values"]}
    return [values.get(f"mn.q{i}_mm") for i in (1, 2, 3)]


class Push:
    """By how much the axes of the robot above are off the place where they came to rest, as an outsider reads it. The axes arrive
    one by one, so a place counts once two readings, the second a later one, agree within 100 nm."""

    def __init__(self, cell):
        self.cell, self.before, self.rest = cell, None, None

    def pressed_mm(self):
        """The push when all axes give way alike, by 400 nm to 50 um; else None."""
        now, before = read_back(self.cell), self.before
        if None in now or now == before:
            return None
        self.before = now
        if before is None or max(abs(a - b) for a, b in zip(now, before)) > 1e-4:
            return None
        push = [a - b for a, b in zip(now, self.rest or now)]
        if self.rest is None or max(map(abs, push)) > 0.05 or max(push) - min(push) > 1e-4:
            self.rest = now
            return None
        return push if min(map(abs, push)) > 4e-4 else None


def lost_contact(cell, text):
    """The read-back of an axis shows no push any more while the contact is pressed."""
    for found, instead in (("press_mm = 0.00075", "press_mm = 0.02"), ("abort_nm = 1000.0", "abort_nm = 100000.0"),
                           ("closed_loop_y_um = [100]", "closed_loop_y_um = []"), ("\nx_um = [250, 500, 750, 1000]", "\nx_um = []"),
                           ("\ny_um = [250, 500, 750, 1000]", "\ny_um = []")):
        check(found in text, f"the file has {found!r}")
        text = text.replace(found, instead)
    file = cell.write("indentation.toml", text)
    measured(cell, "mn_again", motor_rows("mn", [(0.1, 0.1, 0.1)]), "tool")
    import subprocess
    with open(cell.path("indent.err"), "w", encoding="utf-8") as errors:
        client = subprocess.Popen([BIN + "/driftwise", "indent", "start", file, "--json"], cwd=cell.folder, stdout=subprocess.DEVNULL, stderr=errors,
                                  env={**os.environ, "NO_COLOR": "1"})
        said = lambda: open(cell.path("indent.err"), encoding="utf-8").read()
        until("the zero's stage", lambda: "zero" in said() or "answered by" in said() and "accepted" in said() or client.poll() is not None, 400)
        end, push, pressed = time.monotonic() + 300, Push(cell), None
        while client.poll() is None and time.monotonic() < end and not pressed:
            pressed = push.pressed_mm()
        if pressed:
            print(f"    pressed by {[round(one * 1e6) for one in pressed]} nm", flush=True)
            cell.control(f"fault lie upper jump {-pressed[0]}")
        client.wait(300)
    cell.control("fault clear upper")
    print("    " + said().strip().splitlines()[-1], flush=True)
    error = json.loads([line for line in said().splitlines() if line.startswith("{")][-1])["error"]
    check(pressed and client.returncode == REFUSED and error["reason"] == "CONTACT_LOST", f"a lost contact: exit {client.returncode}, {error['reason']}")
    for part in ("The contact is lost", "see that tool and work-piece are fixed", "the same command goes on"):
        check(part in error["message"], f"  its sentence has {part!r}")
    shown = cell.ask("indent", "show", "1")
    check("The contact is lost" in shown["ended"] and not shown.get("in_contact"), "the daemon's record has the end, and no contact")
    check(any("contact is lost" in one["trouble"] for one in shown["record"]["contact_list"]), "  and the contact with its trouble")


def main():
    cell_files()
    edits = [('min = -4.9\nmax = 4.9\n\n[[setup]]\nname = "level"', 'min = -4.9\nmax = 0.3\n\n[[setup]]\nname = "level"'),
             ('after_power_loss = "wait"', 'after_power_loss = "go-on"')]
    with Cell(access=False, name="two-robots", speed=20, edit=edits) as cell:
        setups_and_joins(cell)
        models = plans(cell)
        text = tools(cell, models)
        lost_contact(cell, text)
    print(f"{outside.passed} checks passed")


if __name__ == "__main__":
    sys.exit(main())
