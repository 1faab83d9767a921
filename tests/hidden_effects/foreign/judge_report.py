"""Rates of recorded diagnoses, with Clopper-Pearson intervals, by stratum."""
import json
import math
import os

# A finding's subject says little for these: any is right.
ANY_SUBJECT = {"geometry_order", "outliers", "noise_change", "force_compliance", "force_nonlinearity",
               "force_position_coupling"}
# Tolerance of held-out figures: docs/diagnosis.md.
WORSE = 1.02
# Shares of the planted strength that the readings carry: upper bounds of the groups, and their names.
SHARES = ((0.3, "below 0.3"), (0.7, "0.3 to 0.7"), (float("inf"), "at least 0.7"))
# Least share with which a data set counts as identifiable in the readings as they are written to the file.
IN_READINGS = 0.5
# Promised exact rates of identifiable data sets, by kind and strength.
PROMISED = {("single", 75): 0.95, ("single", 150): 0.98, ("pair", 200): 0.90}


def read_results(path):
    if not os.path.exists(path):
        return []
    results = {}
    with open(path) as lines:
        for line in lines:
            if line.endswith("\n"):
                result = json.loads(line)
                results[result["number"]] = result
    return [results[number] for number in sorted(results)]


def binomial_tail(k, n, p):
    """P(X >= k) for X ~ Bin(n, p)."""
    if k <= 0:
        return 1.0
    if p <= 0.0:
        return 0.0
    if p >= 1.0:
        return 1.0
    terms = [math.lgamma(n + 1) - math.lgamma(i + 1) - math.lgamma(n - i + 1)
             + i * math.log(p) + (n - i) * math.log1p(-p) for i in range(k, n + 1)]
    top = max(terms)
    return min(1.0, math.exp(top) * sum(math.exp(t - top) for t in terms))


def interval(k, n, level=0.95):
    """Clopper-Pearson interval of k of n."""
    if n == 0:
        return 0.0, 1.0
    half = (1.0 - level) / 2.0

    def root(goal, tail):
        low, high = 0.0, 1.0
        for _ in range(60):
            middle = 0.5 * (low + high)
            if tail(middle) < goal:
                low = middle
            else:
                high = middle
        return 0.5 * (low + high)

    lower = 0.0 if k == 0 else root(half, lambda p: binomial_tail(k, n, p))
    upper = 1.0 if k == n else root(1.0 - half, lambda p: binomial_tail(k + 1, n, p))
    return lower, upper


def same_subject(truth, finding, key):
    if truth["cause"] in ANY_SUBJECT or truth["subject"] in ("", None):
        return True
    subject = finding.get("subject") or ""
    poses = {"linear": ["x"]}.get(key["robot"], key.get("pose") or [])
    alike = set(truth["subjects"])
    # One axis, one scale: its motor and its pose are the same coordinate.
    if key["axes"] == 1:
        alike |= {"q1", "x", "z", "rz"} if alike & {"q1", "x", "z", "rz"} else set()
    for name in list(alike):
        if name in poses:
            alike.add("q%d" % (poses.index(name) + 1))
    # A sum of neighbours stands for each of them.
    return subject in alike or subject.split(" ")[0] in alike


def judge(line):
    """Outcome of one data set."""
    key, result = line["key"], line["result"]
    allowed = set(key["allowed"])
    # A spread that depends on the place or the hour may be named, whatever else is hidden.
    findings = [f for f in result["findings"] if f["cause"] not in allowed
                or f["cause"] in {t["cause"] for t in key["hidden"]}]
    out = {"names": len(findings), "verdict": result["verdict"]}
    out["failed"] = result["verdict"] == "none"
    ratios = [f["extended"] / f["baseline"] for f in result.get("held_out", {}).values()
              if f.get("baseline") and "extended" in f and key["sets"]]
    out["ratio"] = max(ratios) if ratios else None
    # Worse than the baseline's by more than the tolerance and beyond its 90 % interval. Without an
    # interval the ratio decides alone.
    out["worse"] = result["verdict"] == "extended" and any(
        f["extended"] / f["baseline"] > WORSE and (f.get("extended_ci90") or [math.inf])[0] > f["baseline"]
        for f in result.get("held_out", {}).values() if f.get("baseline") and "extended" in f and key["sets"])
    if key["kind"] == "null":
        quiet = not findings and (result["verdict"] == "adequate" or
                                  (result["verdict"] == "extended" and len(result["findings"]) > 0))
        out["right"] = quiet
    elif key["kind"] == "unlisted":
        out["right"] = result["verdict"] == "unexplained"
        out["misnamed"] = bool(findings)
    else:
        left = list(findings)
        exact = in_set = cause_only = True
        for truth in key["hidden"]:
            match = next((f for f in left if f["cause"] == truth["cause"] and same_subject(truth, f, key)), None)
            if match is None:
                exact = False
                alike = next((f for f in left if f["cause"] == truth["cause"]), None)
                cause_only = cause_only and alike is not None
                match = next((f for f in left if reaches(truth, f)), None)
                if match is None:
                    in_set = False
            if match is not None:
                left.remove(match)
        out["exact"] = exact and not left
        out["in_set"] = out["exact"] or (in_set and not left)
        out["cause_right"] = out["exact"] or (cause_only and len(findings) == len(key["hidden"]))
        out["false_beside"] = bool(left)
        out["identifiable"] = all(t["identifiable"] for t in key["hidden"])
        out["right"] = out["exact"] if out["identifiable"] else out["in_set"]
    return out


def reaches(truth, finding):
    """The finding's set holds the truth, or the generator's set of the truth holds the finding."""
    names = [entry if isinstance(entry, str) else entry.get("cause", "")
             for entry in finding["indistinguishable_from"]]
    if any(name.split(" ")[0] == truth["cause"] for name in names):
        return True
    return any(rival["cause"] == finding["cause"] for rival in truth["set"])


def rate_text(k, n):
    low, high = interval(k, n)
    return f"{k}/{n} = {100.0 * k / max(n, 1):.1f} % [{100 * low:.1f}, {100 * high:.1f}]"


def carried_share(line, figure="chi2_in_readings"):
    """Least share of its planted chi2 that the readings carry, over the hidden causes; None: not in the key."""
    shares = [truth[figure] / truth["chi2"] for truth in line["key"]["hidden"] if figure in truth]
    return min(shares) if shares and len(shares) == len(line["key"]["hidden"]) else None


def share_group(share):
    return next(name for bound, name in SHARES if share < bound)


def by_share(lines, markdown):
    """Identifiable singles and pairs by what the readings carry. A breakdown, which the promises do not use."""
    sure = [l for l in lines if l["key"]["kind"] in ("single", "pair") and l["outcome"]["identifiable"]]
    known = [l for l in sure if carried_share(l) is not None]
    if not known:
        return
    print(("\n## " if markdown else "\n=== ") + "Breakdown by what the readings carry: identifiable, exact")
    print("Share: chi2_in_readings / chi2 of the key, of pairs the lesser one. The promises above are over all of them.")
    if len(known) < len(sure):
        print(f"keys without the figure: {len(sure) - len(known)} of {len(sure)} (judge.py rekey)")
    if markdown:
        print("\n| kind | share | count | exact, with 95 % interval |\n|---|---|---|---|")
    kinds = sorted({(l["key"]["kind"], l["key"]["chi2"]) for l in known}, key=lambda k: (k[0] != "single", k[1]))
    for kind, chi2 in kinds + [("all", None)]:
        own = [l for l in known if kind == "all" or (l["key"]["kind"], l["key"]["chi2"]) == (kind, chi2)]
        title = "all" if kind == "all" else f"{kind} {chi2:g}"
        for _, name in SHARES:
            group = [l["outcome"]["exact"] for l in own if share_group(carried_share(l)) == name]
            text = rate_text(sum(group), len(group)) if group else "none"
            print(f"| {title} | {name} | {len(group)} | {text} |" if markdown else f"  {title:12s} {name:14s} {text}")
    print()
    for kind, chi2 in kinds:
        own = [l["outcome"]["exact"] for l in known if (l["key"]["kind"], l["key"]["chi2"]) == (kind, chi2)
               and carried_share(l) >= IN_READINGS]
        print(f"{'- ' * markdown}breakdown, not the promise: {kind} {chi2:g}, exact, of those identifiable in the "
              f"readings as written (share at least {IN_READINGS:g}): {rate_text(sum(own), len(own))}")
    for kind, chi2 in kinds:
        own = [l["outcome"]["exact"] for l in known if (l["key"]["kind"], l["key"]["chi2"]) == (kind, chi2)
               and share_group(carried_share(l)) == SHARES[-1][1]]
        rate = PROMISED.get((kind, chi2))
        print(f"{'- ' * markdown}breakdown, not the promise: {kind} {chi2:g}, exact, of those whose readings carry at "
              f"least 0.7: {rate_text(sum(own), len(own))}"
              + (f"; promised over all: {100 * rate:g} %" if rate else ""))
    moved = [str(l["number"]) for l in known
             if share_group(carried_share(l, "chi2_in_smoothed_readings")) != share_group(carried_share(l))]
    print("in another group when thermometers are smoothed over the rows: " + (", ".join(moved) or "none"))
    missed = [l for l in known if not l["outcome"]["exact"] and share_group(carried_share(l)) == SHARES[-1][1]]
    print(f"missed with at least 0.7: {len(missed)}")
    for l in missed:
        key = l["key"]
        causes = "; ".join(f"{t['cause']} {t['subject']} chi2 {t['chi2']:.1f}, in readings {t['chi2_in_readings']:.1f}"
                           for t in key["hidden"])
        said = ", ".join(f"{f['cause']} {f.get('subject') or ''}".strip() for f in l["result"]["findings"])
        print(f"  {l['number']} {key['kind']} {key['robot']} {key['plan']} {key['noise']}: {causes} -> "
              f"{l['outcome']['verdict']}{' ' + said if said else ''}")


def strata_of(line):
    key = line["key"]
    stroke = key["stroke"]
    strata = {"robot": key["robot"], "axes": str(key["axes"]), "plan": key["plan"], "noise": key["noise"],
              "units": key["units"], "varied": key["varied"],
              "thermometers": {0: "none"}.get(len(key["thermometers"]), "some"),
              "times": "timed" if key["times"] else "untimed", "sets": "sets" if key["sets"] else "no sets",
              "stroke": "below 1 mm" if stroke < 1 else "1 to 30 mm" if stroke < 30 else
                        "30 to 1000 mm" if stroke < 1000 else "above 1 m"}
    for truth in key["hidden"][:1]:
        strata["cause"] = truth["cause"]
    return strata


def table(title, lines, good, worst_is_low, by, markdown):
    """Rates of `good` by stratum, worst first."""
    groups = {}
    for line in lines:
        name = strata_of(line).get(by)
        if name is not None:
            groups.setdefault(name, []).append(good(line))
    rows = [(sum(g) / len(g), name, sum(g), len(g)) for name, g in groups.items()]
    rows.sort(key=lambda r: (r[0] if worst_is_low else -r[0], -r[3], r[1]))
    if markdown:
        print(f"\n| {title}, by {by} | count | rate and 95 % interval |\n|---|---|---|")
    else:
        print(f"\n{title}, by {by}:")
    # Holm's step-down over the strata, one-sided, against the promised 1 % (false names only).
    tests = sorted((binomial_tail(k, n, 0.01), name) for _, name, k, n in rows)
    refused = set()
    for position, (p, name) in enumerate(tests):
        if p * (len(tests) - position) >= 0.05:
            break
        refused.add(name)
    for _, name, k, n in rows:
        mark = " above 1 % (Holm)" if not worst_is_low and name in refused else ""
        text = rate_text(k, n) + mark
        print(f"| {name} | {n} | {text} |" if markdown else f"  {name:22s} {text}")


def report(results, markdown=False, promises=False):
    lines = [r for r in results if r.get("key") and r.get("result")]
    for line in lines:
        line["outcome"] = judge(line)
    refuted = []

    def head(name):
        print(f"\n## {name}" if markdown else f"\n=== {name}")

    def promise(name, k, n, rate, at_most=False):
        low, high = interval(k, n)
        broken = n > 0 and (low > rate if at_most else high < rate)
        verdict = "refuted" if broken else "not refuted"
        print(f"{'- ' if markdown else ''}{name}: {rate_text(k, n)}; promised {'at most' if at_most else 'at least'} "
              f"{100 * rate:g} %: {verdict}")
        if broken:
            refuted.append(name)

    # Twins in other units count in the test of units only.
    counted = [l for l in lines if "twin" not in l["order"]]
    kinds = {kind: [l for l in counted if l["key"]["kind"] == kind]
             for kind in ("null", "single", "pair", "unlisted")}
    nulls = kinds["null"]
    if nulls:
        head(f"Nothing hidden: {len(nulls)} data sets")
        promise("a name", sum(l["outcome"]["names"] > 0 for l in nulls), len(nulls), 0.01, True)
        promise("a name, or a verdict but adequate", sum(not l["outcome"]["right"] for l in nulls), len(nulls), 0.02, True)
        for by in ("robot", "plan", "noise", "units", "varied", "stroke", "thermometers", "times"):
            table("false alarms", nulls, lambda l: not l["outcome"]["right"], False, by, markdown)
        names = {}
        for line in nulls:
            for finding in line["result"]["findings"]:
                names[finding["cause"]] = names.get(finding["cause"], 0) + 1
        print("\nnamed on nulls: " + (", ".join(f"{n} {c}" for c, n in sorted(names.items(), key=lambda x: -x[1])) or "none"))
    for chi2 in sorted({l["key"]["chi2"] for l in kinds["single"]}):
        singles = [l for l in kinds["single"] if l["key"]["chi2"] == chi2]
        sure = [l for l in singles if l["outcome"]["identifiable"]]
        rest = [l for l in singles if not l["outcome"]["identifiable"]]
        head(f"Single causes at chi2 {chi2:g}: {len(singles)} data sets, {len(sure)} identifiable")
        promise("identifiable, exact", sum(l["outcome"]["exact"] for l in sure), len(sure), 0.98 if chi2 >= 150 else 0.95)
        print("identifiable, exact or in the set: " + rate_text(sum(l["outcome"]["in_set"] for l in sure), len(sure)))
        print("identifiable, right cause, subject not asked: " + rate_text(sum(l["outcome"]["cause_right"] for l in sure), len(sure)))
        print("not identifiable, exact or in the set: " + rate_text(sum(l["outcome"]["in_set"] for l in rest), len(rest)))
        print("something false beside: " + rate_text(sum(l["outcome"]["false_beside"] for l in singles), len(singles)))
    singles = kinds["single"]
    if singles:
        head("Single causes, both strengths: right = exact where identifiable, else in the set")
        for by in ("cause", "robot", "plan", "noise", "units", "varied", "stroke"):
            table("right", singles, lambda l: l["outcome"]["right"], True, by, markdown)
    if kinds["pair"]:
        pairs = kinds["pair"]
        sure = [l for l in pairs if l["outcome"]["identifiable"]]
        head(f"Pairs: {len(pairs)} data sets, {len(sure)} identifiable")
        promise("identifiable, exact", sum(l["outcome"]["exact"] for l in sure), len(sure), 0.90)
        print("all, exact or in the set: " + rate_text(sum(l["outcome"]["in_set"] for l in pairs), len(pairs)))
    by_share(counted, markdown)
    if kinds["unlisted"]:
        others = kinds["unlisted"]
        head(f"In no catalogue: {len(others)} data sets")
        promise("unexplained", sum(l["outcome"]["right"] for l in others), len(others), 0.80)
        promise("misnamed", sum(l["outcome"]["misnamed"] for l in others), len(others), 0.03, True)
        for by in ("cause", "robot", "plan"):
            table("unexplained", others, lambda l: l["outcome"]["right"], True, by, markdown)
    head("Held out, time and failures")
    extended = [l for l in lines if l["outcome"]["verdict"] == "extended" and l["outcome"]["ratio"] is not None]
    worse = [l for l in extended if l["outcome"]["worse"]]
    print(f"extended with a figure held out more than 2 % worse: {len(worse)} of {len(extended)}"
          + (f", worst {max(l['outcome']['ratio'] for l in worse):.2f} times (number "
             f"{max(worse, key=lambda l: l['outcome']['ratio'])['number']})" if worse else ""))
    failed = [l for l in lines if l["outcome"]["failed"]]
    print(f"no verdict at all: {len(failed)} of {len(lines)}")
    for line in failed[:8]:
        print(f"  number {line['number']}: exit {line['result']['exit']}: {line['result'].get('error', '')[:160]}")
    print(f"orders without a data set (strength not reachable): {sum(1 for r in results if 'refused' in r)}")
    for name, low, high in (("one axis", 1, 1), ("two and three axes", 2, 3), ("four to six axes", 4, 6)):
        for found in (False, True):
            times = sorted(l["result"]["cpu_s"] for l in lines if low <= l["key"]["axes"] <= high
                           and bool(l["result"]["findings"]) == found)
            if times:
                print(f"processor time, {name}, {'something' if found else 'nothing'} named: median "
                      f"{times[len(times) // 2]:.2f} s, 90 % {times[int(0.9 * (len(times) - 1))]:.2f} s, "
                      f"largest {times[-1]:.2f} s ({len(times)})")
    twins(lines)
    return 1 if promises and refuted else 0


def canonical(line):
    """Verdict and findings with the file's names put back to the study's."""
    key = line["key"]
    back = {name: f"t{k + 1:02d}" for k, name in enumerate(key["thermometers"])}
    back[key["activity"]] = "activity"
    return line["result"]["verdict"], sorted((f["cause"], back.get(f.get("subject"), f.get("subject")))
                                             for f in line["result"]["findings"])


def twins(lines):
    pairs = {}
    for line in lines:
        if "twin" in line["order"]:
            pairs.setdefault(line["order"]["twin"], []).append(line)
    pairs = {k: v for k, v in pairs.items() if len(v) == 2}
    if pairs:
        unlike = [k for k, (a, b) in pairs.items() if canonical(a) != canonical(b)]
        print(f"same readings in other units and names, other answer: {rate_text(len(unlike), len(pairs))}")
        for k in unlike[:5]:
            print(f"  twin {k}: {canonical(pairs[k][0])} against {canonical(pairs[k][1])}")


def compare(before, after):
    """Paired counts of right answers; exact McNemar test."""
    first = {r["number"]: judge(r) for r in before if r.get("result")}
    second = {r["number"]: judge(r) for r in after if r.get("result")}
    both = sorted(set(first) & set(second))
    lost = [n for n in both if first[n]["right"] and not second[n]["right"]]
    won = [n for n in both if second[n]["right"] and not first[n]["right"]]
    n = len(lost) + len(won)
    p = min(1.0, 2.0 * binomial_tail(max(len(lost), len(won)), n, 0.5)) if n else 1.0
    print(f"{len(both)} paired; right before {sum(first[k]['right'] for k in both)}, "
          f"after {sum(second[k]['right'] for k in both)}; won {len(won)}, lost {len(lost)}; McNemar p = {p:.3g}")
    if lost:
        print("lost: " + " ".join(map(str, lost)))
    kinds = {r["number"]: " ".join([r["key"]["kind"]] + ([f"chi2 {r['key']['chi2']:g}"] if r["key"]["hidden"] else []))
             for r in after if r.get("result")}
    for kind in sorted(set(kinds[k] for k in both)):
        own = [k for k in both if kinds[k] == kind]
        print(f"  {kind}: {len(own)}; right {sum(first[k]['right'] for k in own)} -> {sum(second[k]['right'] for k in own)}, "
              f"won {sum(k in won for k in own)}, lost {sum(k in lost for k in own)}")
    worse = [sum(side[k]["worse"] for k in both) for side in (first, second)]
    print(f"  extended with a figure held out more than 2 % worse: {worse[0]} -> {worse[1]}")
    return 1 if len(lost) > len(won) and p < 0.05 else 0
