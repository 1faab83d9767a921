#!/usr/bin/python3
"""Texts that would command a terminal, a page or a report, given wherever a person, a file or a device gives one: notes, run
and trajectory names, operators, metadata, and (put into the file by SQL, as an older record or a device may hold them)
reasons and events. Every output shows them, and none obeys.

Usage: hostile_texts.py BIN SOURCE
"""
import json
import os
import re
import sys

from cell import SOURCE, Cell, check

TEXTS = ["\x1b]0;pwned\x07", "\x1b[2J\x1b[H", "\x9b2J", "a\rb", "a\nrun 1 succeeded", "\u202egnp.exe", "\u2066x\u2069",
         "<script>alert(1)</script>", "</script><script>alert(2)</script>", "<!--<script>", "\"><img src=x onerror=alert(3)>",
         "{{7*7}}", "javascript:alert(4)", "=cmd|' /C calc'!A1", "*/ int evil(void); /*", "%s%n%s", "\x00end", "\U000e0001tag"]
OBEYED = re.compile("[\x00-\x08\x0b-\x1f\x7f\x80-\x9f\u061c\u200e\u200f\u202a-\u202e\u2066-\u2069\ufff9-\ufffb]")


def inert(text, what):
    found = OBEYED.search(text.replace("\r\n", "\n"))
    check(found is None, f"{what} commands no terminal" + (f": {text[max(0, found.start() - 40):found.start() + 20]!r}" if found else ""))


def main():
    with Cell(access=False) as cell:
        def give(*words):
            # A NUL ends an argument; the operating system refuses it.
            done = cell.cli(*(word.replace("\x00", "") for word in words))
            inert(done.stdout, "the answer to " + " ".join(words[:2]))
            inert(done.stderr, "the complaint about " + " ".join(words[:2]))
            return done

        data = cell.path("data.csv")
        runs = []
        for number, text in enumerate(TEXTS):
            with open(data, "w", encoding="utf-8", newline="") as file:
                file.write("# operator: " + text.replace("\n", " ") + "\n# note " + text.replace("\n", " ") + "\n"
                           "time_s,q1_mm,x_mm\n" + "".join(f"{i},{i / 10 + 0.001 * (i % 3)},{i / 10}\n" for i in range(9)))
            done = give("data", "import", data, "--name", f"{number} {text}", "--operator", f"eve {text}", "--json")
            if done.returncode == 0:
                runs.append(str(json.loads(done.stdout)["id"]))
                give("note", "add", f"remark {text}", "--run", runs[-1], "--operator", f"eve {text}")
        check(len(runs) > 10, f"{len(runs)} of {len(TEXTS)} texts were taken as names of runs")
        plan = cell.path("plan.csv")
        with open(plan, "w", encoding="ascii") as file:
            file.write("q1_mm\n0\n0.1\n")
        measured = give("run", "start", plan, "--name", "<script>alert(5)</script>\x1b[31m", "--operator", "\x1b]0;x\x07<b>", "--json")
        number = str(json.loads(measured.stdout)["id"])
        give("note", "add", "</script><script>alert(6)</script>", "--run", number)
        give("run", "watch", number, "--timeout", "100")
        give("fit", "--run", runs[0], "--model", "q1 ~ x", "--name", "*/ evil \x1b[2J </script>", "--note", "\x1b[2J*/")
        give("stop", "--operator", "\x1b[2Jroot")
        cell.stop()
        # As an older program or a device's words may stand there: not cleaned at the door in.
        raw = "x'" + "\x1b[2J</script><script>alert(7)</script>\u009b2J".encode().hex() + "'"
        cell.sql(f"UPDATE event SET detail = CAST({raw} AS TEXT) WHERE event_id = 2; "
                 f"UPDATE run SET name = CAST({raw} AS TEXT) WHERE run_id = {runs[1]}; "
                 f"UPDATE attempt SET reason = CAST({raw} AS TEXT) WHERE attempt_id = 1; "
                 f"UPDATE audit SET who = CAST({raw} AS TEXT), outcome = CAST({raw} AS TEXT) WHERE audit_id = 1")
        cell.start()
        lists = [("status",), ("run", "list"), ("events",), ("audit", "list"), ("audit", "verify"), ("model", "list"), ("alarms",),
                 ("model", "show", "1"), ("model", "export", "1", "--format", "c"), ("model", "export", "1"), ("model", "history"),
                 ("configuration", "list"), ("whoami",), ("diagnosis", "list"), ("trajectory", "list")]
        lists += [("run", "show", run) for run in runs[:4] + [number]] + [("data", "export", run) for run in runs]
        lists += [("run", "points", number), ("run", "attempts", number), ("data", "exclusions", runs[0])]
        for words in lists:
            give(*words)
            if words[0] != "data" and words[-1] != "c" and "export" not in words:
                give(*words, "--json")
        source = cell.cli("model", "export", "1", "--format", "c").stdout
        check(source.count("/*") == source.count("*/") and "evil \x1b" not in source, "no name ends a comment of the exported C")
        again = cell.cli("audit", "list", "--database", cell.database())
        inert(again.stdout, "a record that is read without a daemon")
        log = open(cell.path("driftwised.log"), encoding="utf-8", errors="replace").read()
        inert(log, "the daemon's log")
        status, fields, content = cell.http("web", "GET", "/metrics")
        inert(content.decode(), "the page of metrics")
        # The page shows texts as texts: one place writes markup, the plot on paper, whose texts are escaped (svg.ts, with its own
        # test); and the door forbids scripts that are not of its files.
        status, fields, _ = cell.http("web", "GET", "/")
        policy = dict((name.lower(), value) for name, value in fields).get("content-security-policy", "")
        check("script-src 'self';" in policy, "a page's own scripts are all that is executed: " + policy[:80])
        writers = set()
        for folder, _, names in os.walk(os.path.join(SOURCE, "clients/web/src")):
            for name in (one for one in names if one.endswith((".ts", ".tsx"))):
                text = open(os.path.join(folder, name), encoding="utf-8").read()
                if re.search(r"dangerouslySetInnerHTML|\.(inner|outer)HTML\s*=|insertAdjacentHTML|document\.write\(", text):
                    writers.add(name)
        check(writers <= {"plot.tsx"}, "one part of the page writes markup: " + ", ".join(writers))
        if os.path.exists(os.path.join(SOURCE, "clients/web/dist/report.html")):
            template = os.path.join(SOURCE, "clients/web/dist/report.html")
            give("report", "run", number, "-o", cell.path("report.html"))
            report = open(cell.path("report.html"), encoding="utf-8").read()
            inert(report, "the report")
            before = open(template, encoding="utf-8").read()
            check(report.count("<script") == before.count("<script") and report.count("</script") == before.count("</script"),
                  "no text becomes a script of the report")
            shown = json.loads(report.split('id="report-data">')[1].split("</script>")[0])
            check("alert(5)" in shown["run"]["name"], "which still has it, as a text")
            check(re.fullmatch(r"[0-9a-f]{64}@\d+", shown["record_head"]) is not None, "and the head of the record's chain")
        else:
            print("NOT TRIED: the report (clients/web/dist is not built)")
        exported = json.loads(cell.cli("model", "export", "1").stdout)
        check(re.fullmatch(r"[0-9a-f]{64}@\d+", exported["record_head"]) is not None, "an exported model carries the head away")
        check("Head of the record's chain: " in source, "in C as a comment")
        check("record_head" in cell.ask("model", "show", "1"), "and model show has it")
    return 0


if __name__ == "__main__":
    sys.exit(main())
