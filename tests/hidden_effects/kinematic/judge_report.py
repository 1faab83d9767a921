"""Rates of recorded answers with Clopper-Pearson intervals, by stratum, and what went wrong."""
import collections
import json
import math

from judge_rules import classify, parameter, worse_held_out

STRATA = ("cause", "family", "plan", "noise", "split", "chi2")
# Strata with fewer data sets are not ranked.
RANKED_FROM = 3


def tail(n, k, p):
    """Probability of k or more of n."""
    if p <= 0:
        return float(k <= 0)
    terms = (
        math.lgamma(n + 1)
        - math.lgamma(m + 1)
        - math.lgamma(n - m + 1)
        + m * math.log(p)
        + (n - m) * math.log1p(-p)
        for m in range(k, n + 1)
    )
    return sum(math.exp(term) for term in terms)


def bisect(f, target):
    low, high = 0.0, 1.0
    for _ in range(50):
        middle = (low + high) / 2
        low, high = (middle, high) if f(middle) < target else (low, middle)
    return (low + high) / 2


def interval(k, n):
    """Clopper-Pearson interval of 95 %."""
    low = 0.0 if k == 0 else bisect(lambda p: tail(n, k, p), 0.025)
    high = 1.0 if k == n else bisect(lambda p: tail(n, k + 1, p), 0.975)
    return low, high


def rate(k, n):
    if n == 0:
        return "0 of 0"
    low, high = interval(k, n)
    return "%d of %d (%.1f %%, %.1f to %.1f)" % (k, n, 100 * k / n, 100 * low, 100 * high)


def stratum(key, name):
    if name == "cause":
        return key["truth"][0]["cause"] if len(key["truth"]) == 1 else None
    if name == "chi2":
        if key["kind"] != "single":
            return None
        return "75" if key["target"] < 110 else "150" if key["target"] < 210 else "300"
    return key[name]


def print_strata(title, rows, good):
    """Counts of good answers by stratum, then the worst strata with their intervals."""
    print("%s: %s" % (title, rate(sum(good(r) for r in rows), len(rows))))
    ranked = []
    for name in STRATA:
        counts = collections.defaultdict(lambda: [0, 0])
        for row in rows:
            value = stratum(row["key"], name)
            if value is not None:
                counts[value][0] += good(row)
                counts[value][1] += 1
        if counts:
            items = sorted(counts.items())
            print("  by %s: %s" % (name, ", ".join("%s %d/%d" % (v, *c) for v, c in items)))
        for value, (k, n) in counts.items():
            if n >= RANKED_FROM and k < n:
                ranked.append((interval(k, n)[1], "%s %s: %s" % (name, value, rate(k, n))))
    for _, text in sorted(ranked)[:5]:
        print("  worst: " + text)


def print_kinds(rows):
    of = lambda kind: [r for r in rows if r["key"]["kind"] == kind]
    exact = lambda r: r["worth"].startswith("exact")
    if of("null"):
        false = sum(r["worth"] == "named" for r in of("null"))
        print("nothing hidden, false name: " + rate(false, len(of("null"))))
        print_strata("nothing hidden, right", of("null"), lambda r: r["worth"] == "right")
    if of("single"):
        seen = [r for r in of("single") if r["key"]["identifiable"]]
        print_strata("singles, identifiable, exact", seen, exact)
        among = sum(exact(r) or r["worth"] == "right+extra" for r in seen)
        print("  named, with or without more: " + rate(among, len(seen)))
        print("singles, all, exact: " + rate(sum(map(exact, of("single"))), len(of("single"))))
    if of("pair"):
        print_strata("pairs, exact", of("pair"), exact)
    if of("unlisted"):
        print_strata(
            "unlisted, unexplained and no name",
            of("unlisted"),
            lambda r: r["worth"] == "unexplained",
        )
        said = sum("unexplained" in r["worth"] for r in of("unlisted"))
        print("  unexplained, with or without a name: " + rate(said, len(of("unlisted"))))
    for kind in ("null", "single", "pair", "unlisted"):
        if of(kind):
            print(kind, dict(collections.Counter(r["worth"] for r in of(kind)).most_common()))


def odd(result):
    """Answer whose exit code is not the verdict's."""
    return result["exit"] not in (0, 1) or (result["exit"] == 1) != (
        result["verdict"] == "unexplained"
    )


def print_runs(rows):
    extended = [r for r in rows if r["result"]["verdict"] == "extended"]
    worse = [(r, worse_held_out(r["result"])) for r in extended]
    worse = [(r, w) for r, w in worse if w]
    sure = sum(any(above for *_, above in w) for _, w in worse)
    print(
        "extended, a held-out figure worse by 2 %%: %d of %d, with its interval wholly above: %d"
        % (len(worse), len(extended), sure)
    )
    for r, w in worse:
        figures = ", ".join("%s %.4g to %.4g%s" % (o, b, a, " (sure)" * s) for o, b, a, s in w)
        print("  %s: %s" % (r["file"], figures))
    for r in rows:
        if odd(r["result"]):
            text = r["result"].get("error", "")[:200]
            print("odd exit code: %s %s %s" % (r["file"], r["result"]["exit"], text))
    times = sorted(((r["result"]["wall_s"], r["file"]) for r in rows), reverse=True)
    print(
        "wall time: median %.1f s, longest %s"
        % (times[len(times) // 2][0], ", ".join("%s %.0f s" % (f, t) for t, f in times[:3]))
    )


def print_misses(rows):
    for r in rows:
        if r["worth"] in ("right", "exact") or (
            r["key"]["kind"] == "unlisted" and r["worth"] == "unexplained"
        ):
            continue
        k = r["key"]
        print(
            "-- %s: %s, %s, %s, %s noise, %d rows (%d), `%s`"
            % (
                r["worth"],
                r["file"],
                k["robot"],
                k["plan"],
                k["noise"],
                k["rows"],
                k["cal"],
                k["baseline"],
            )
        )
        for t in k["truth"]:
            print(
                "   truth: %s %s %s, chi2 %.0f, nearest %s"
                % (
                    t["cause"],
                    t["subject"],
                    json.dumps(t.get("parameters", {}))[:120],
                    t["chi2"],
                    t.get("nearest"),
                )
            )
        for f in r["result"]["findings"]:
            said = {n: parameter(f, n) for n in f.get("parameters") or {}}
            print(
                "   said: %s %s %s, like %s"
                % (f["cause"], f["subject"], json.dumps(said)[:160], f["indistinguishable_from"])
            )


def report(recorded, keys, misses):
    """recorded: results by file name; keys: (path, key) by file name."""
    rows = [
        {
            "file": name,
            "key": key,
            "result": recorded[name],
            "worth": classify(key, path, recorded[name]),
        }
        for name, (path, key) in keys.items()
        if name in recorded
    ]
    print("%d of %d data sets recorded" % (len(rows), len(keys)))
    if not rows:
        return
    print_kinds(rows)
    print_runs(rows)
    if misses:
        print_misses(rows)
