#!/usr/bin/env python3
"""Tests of the judge's arithmetic and of its rule, without any program."""
import contextlib
import io
import json
import os
import tempfile
import unittest

import judge
import judge_report


def line(kind, verdict, findings, hidden=(), **key):
    base = {"kind": kind, "robot": "gantry", "axes": 2, "pose": ["x", "y"], "hidden": list(hidden), "allowed": [],
            "sets": True, "thermometers": ["bed"], "activity": "duty"}
    base.update(key)
    said = [{"cause": c, "subject": s, "indistinguishable_from": i} for c, s, i in findings]
    return {"number": 0, "order": {}, "key": base, "result": {"verdict": verdict, "findings": said, "cpu_s": 1.0}}


LAG = {"cause": "thermal_lag", "subject": "bed", "subjects": ["bed"], "identifiable": True, "set": []}


class Judge(unittest.TestCase):
    def test_clopper_pearson_of_textbook(self):
        low, high = judge_report.interval(4, 20)
        self.assertAlmostEqual(low, 0.0573, places=4)
        self.assertAlmostEqual(high, 0.4366, places=4)
        self.assertEqual(judge_report.interval(0, 10)[0], 0.0)
        self.assertAlmostEqual(judge_report.interval(0, 10)[1], 0.3085, places=4)

    def test_null_is_right_only_when_adequate(self):
        self.assertTrue(judge_report.judge(line("null", "adequate", []))["right"])
        self.assertFalse(judge_report.judge(line("null", "unexplained", []))["right"])
        self.assertFalse(judge_report.judge(line("null", "extended", [("creep", "q1", [])]))["right"])
        spread = [("noise_change", "x", [])]
        self.assertFalse(judge_report.judge(line("null", "extended", spread))["right"])
        self.assertTrue(judge_report.judge(line("null", "extended", spread, allowed=["noise_change"]))["right"])

    def test_single_asks_cause_and_subject(self):
        right = judge_report.judge(line("single", "extended", [("thermal_lag", "bed", [])], [LAG]))
        self.assertTrue(right["exact"])
        other = judge_report.judge(line("single", "extended", [("thermal_lag", "beam", [])], [LAG]))
        self.assertFalse(other["exact"])
        self.assertTrue(other["cause_right"])
        two = judge_report.judge(line("single", "extended", [("thermal_lag", "bed", []), ("creep", "q1", [])], [LAG]))
        self.assertFalse(two["exact"] or two["in_set"])

    def test_set_counts_when_it_holds_the_truth(self):
        held = [("self_heating", "q1", ["thermal_lag bed"])]
        outcome = judge_report.judge(line("single", "extended", held, [LAG]))
        self.assertTrue(outcome["in_set"] and not outcome["exact"])

    def test_worse_held_out_is_seen(self):
        bad = line("single", "extended", [("thermal_lag", "bed", [])], [LAG])
        bad["result"]["held_out"] = {"q1": {"baseline": 20.0, "extended": 21.0}, "q2": {"baseline": 9.0, "extended": 5.0}}
        self.assertTrue(judge_report.judge(bad)["worse"])
        bad["result"]["held_out"]["q1"]["extended_ci90"] = [20.1, 22.0]
        self.assertTrue(judge_report.judge(bad)["worse"])
        bad["result"]["held_out"]["q1"]["extended_ci90"] = [19.9, 22.2]
        self.assertFalse(judge_report.judge(bad)["worse"], "within its interval")

    def test_share_is_of_the_lesser_cause_and_absent_from_older_keys(self):
        self.assertIsNone(judge_report.carried_share(line("single", "adequate", [], [LAG])))
        strong = dict(LAG, chi2=200.0, chi2_in_readings=190.0)
        weak = dict(LAG, chi2=200.0, chi2_in_readings=40.0)
        self.assertAlmostEqual(judge_report.carried_share(line("pair", "adequate", [], [strong, weak])), 0.2)
        self.assertIsNone(judge_report.carried_share(line("pair", "adequate", [], [strong, LAG])))
        self.assertEqual([judge_report.share_group(s) for s in (0.0, 0.2999, 0.3, 0.6999, 0.7, 1.0)],
                         ["below 0.3"] * 2 + ["0.3 to 0.7"] * 2 + ["at least 0.7"] * 2)

    def test_breakdown_counts_identifiable_sets_and_leaves_the_promise_over_all(self):
        def made(number, share, named, identifiable=True):
            truth = dict(LAG, chi2=150.0, chi2_in_readings=150.0 * share, chi2_in_smoothed_readings=150.0 * share,
                         identifiable=identifiable)
            one = line("single", "extended" if named else "adequate", [("thermal_lag", "bed", [])] if named else [],
                       [truth], chi2=150, plan="lattice", noise="white", stroke=10, units="study", varied="all",
                       times=True)
            return dict(one, number=number)

        lines = [made(1, 0.1, False), made(2, 0.1, False), made(3, 0.9, True), made(4, 0.9, True),
                 made(5, 0.9, False), made(6, 0.9, False, identifiable=False)]
        printed = io.StringIO()
        with contextlib.redirect_stdout(printed):
            judge_report.report(lines)
        text = printed.getvalue()
        self.assertIn("identifiable, exact: 2/5 = 40.0 %", text)
        self.assertIn("of those whose readings carry at least 0.7: 2/3 = 66.7 %", text)
        self.assertIn("identifiable in the readings as written (share at least 0.5): 2/3 = 66.7 %", text)
        self.assertIn("below 0.3      0/2 = 0.0 %", text)
        self.assertIn("missed with at least 0.7: 1", text)

    def test_new_key_replaces_the_old_one_only_if_it_says_the_same(self):
        order = {"kind": "single", "number": 7, "seed": 7}
        old = {"file": "f.csv", "hidden": [{"cause": "creep", "chi2": 75}]}
        more = {"file": "f.csv", "hidden": [{"cause": "creep", "chi2": 75, "chi2_in_readings": 70.5}]}
        unlike = {"file": "f.csv", "hidden": [{"cause": "creep", "chi2": 74, "chi2_in_readings": 70.5}]}
        saved = judge.generate
        try:
            for new, code, kept in ((more, 0, more), (unlike, 1, old)):
                with tempfile.TemporaryDirectory() as work, contextlib.redirect_stdout(io.StringIO()):
                    path = os.path.join(work, "results.jsonl")
                    with open(path, "w") as results:
                        results.write(json.dumps({"number": 7, "order": order, "key": old, "result": {"exit": 0}}) + "\n")
                    judge.generate = lambda generator, order, folder, new=new: (new, "")
                    self.assertEqual(judge.rekey(work, "generator"), code)
                    self.assertEqual(judge_report.read_results(path)[0],
                                     {"number": 7, "order": order, "key": kept, "result": {"exit": 0}})
        finally:
            judge.generate = saved

    def test_sizes_are_balanced_and_twins_share_a_seed(self):
        saved = judge.listed
        judge.listed = lambda generator, title: [f"{title}_{k}" for k in range(23 if title == "cause" else 12)]
        try:
            quick = judge.orders("", "quick", 1000)
            self.assertEqual(len(quick), 150)
            self.assertEqual(len({o["seed"] for o in quick}), 144)
            self.assertFalse(any(o["reserved"] for o in quick))
            full = judge.orders("", "full", 1000)
            self.assertEqual(sum(o["kind"] == "null" and "twin" not in o for o in full), 2000)
            self.assertEqual(sum(o.get("cause") == "cause_3" and o.get("chi2") == 75 for o in full), 40)
            self.assertTrue(any(o["reserved"] for o in full))
            half = quick[:75]
            self.assertTrue(25 <= sum(o["kind"] == "null" for o in half) <= 38)
        finally:
            judge.listed = saved


if __name__ == "__main__":
    unittest.main()
