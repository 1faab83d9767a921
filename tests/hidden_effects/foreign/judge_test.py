#!/usr/bin/env python3
"""Tests of the judge's arithmetic and of its rule, without any program."""
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
