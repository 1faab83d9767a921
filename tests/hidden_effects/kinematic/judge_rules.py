"""Rules of the judge: is a finding the truth, and what is an answer worth."""
import numpy as np

STAGES = ("linear", "xy", "xyz", "flexure2", "flexure3")
AXES = {"linear": ["x"], "xy": ["x", "y"], "scara": ["x", "y"], "flexure2": ["x", "y"]}
PERIODIC = ("cyclic_error", "gear_error")
DIRECTIONAL = ("backlash", "probe_hysteresis")


def axis_of(key, subject):
    """Number of a motor or pose axis, None for another subject."""
    if subject[:1] == "q" and subject[1:].isdigit():
        return int(subject[1:]) - 1
    axes = AXES.get(key["robot"], ["x", "y", "z", "rx", "ry", "rz"])
    return axes.index(subject) if subject in axes else None


def parameter(finding, name):
    value = (finding.get("parameters") or {}).get(name)
    return value.get("value") if isinstance(value, dict) else value


def same_cause(key, truth, said):
    if truth == said:
        return True
    if truth in PERIODIC and said in PERIODIC:
        return True
    return key["robot"] in STAGES and truth in DIRECTIONAL and said in DIRECTIONAL


def same_subject(key, truth, said):
    said = said.replace("force", "F")
    if said == truth:
        return True
    axis = axis_of(key, said)
    return key["robot"] in STAGES and axis is not None and axis == axis_of(key, truth)


def column(path, name):
    """Values of a channel of a data set."""
    with open(path) as lines:
        rows = [line.strip().split(",") for line in lines if line[0] != "#"]
    k = [head.split("_")[0] for head in rows[0]].index(name)
    return np.array([float(row[k]) for row in rows[1:]])


def aliased(key, path, subject, true_period, said_period):
    """Two periods that the places do not tell apart, beyond a polynomial of that axis."""
    x = column(path, subject)
    u = (x - x.mean()) / np.ptp(x)
    Q, _ = np.linalg.qr(np.stack([u**n for n in range(key["degree"] + 1)], 1))

    def wave(period):
        w = np.stack([np.sin(2 * np.pi * x / period), np.cos(2 * np.pi * x / period)], 1)
        return w - Q @ (Q.T @ w)

    U, _, _ = np.linalg.svd(wave(said_period), full_matrices=False)
    true = wave(true_period)
    return float(((U.T @ true) ** 2).sum() / (true**2).sum()) > 0.95


def periods(true, finding):
    """True and said period of a place-bound wave in the file's unit, mm or deg; None if not said.

    A harmonic h of a joint angle has the period 360 / h deg.
    """
    if "period_nm" in true and parameter(finding, "period_nm"):
        return true["period_nm"] * 1e-6, parameter(finding, "period_nm") * 1e-6
    if "harmonic" in true and parameter(finding, "harmonic"):
        return 360 / true["harmonic"], 360 / parameter(finding, "harmonic")
    if "harmonic" in true and parameter(finding, "period_arcsec"):
        return 360 / true["harmonic"], parameter(finding, "period_arcsec") / 3600
    return None


def match(key, path, truth, finding):
    """Empty if the finding is the truth, else what differs: cause, subject or a parameter."""
    cause, true = truth["cause"], truth.get("parameters") or {}
    if not same_cause(key, cause, finding["cause"]):
        return "cause"
    # Outliers have no subject, and which rows they are is not compared.
    if cause == "outliers":
        return ""
    time_s = parameter(finding, "time_s")
    # Noise of one pose axis is in every motor of such a robot: the instant is what counts.
    if cause == "noise_change" and key["robot"] not in STAGES:
        near = time_s is not None and abs(time_s - true["time_s"]) < 0.05 * key["span_s"]
        return "" if near else "time"
    if not same_subject(key, truth["subject"], finding.get("subject") or ""):
        return "subject"
    tau_s = parameter(finding, "tau_s")
    if "tau_s" in true and tau_s and not 1 / 2.5 < tau_s / true["tau_s"] < 2.5:
        return "tau"
    place = periods(true, finding)
    if place and not 0.97 < place[1] / place[0] < 1.03:
        if not aliased(key, path, truth["subject"], *place):
            return "period"
    period_s = parameter(finding, "period_s")
    if "period_s" in true and period_s and not 0.93 < period_s / true["period_s"] < 1.07:
        return "period"
    if cause == "step_change" and time_s:
        if abs(time_s - true["time_s"]) > 0.03 * key["span_s"] + 60:
            return "time"
    return ""


def classify(key, path, result):
    """Worth of an answer in words."""
    findings, truths, verdict = result["findings"], key["truth"], result["verdict"]
    if key["kind"] == "null":
        if findings:
            return "named"
        return "right" if verdict == "adequate" else verdict
    if key["kind"] == "unlisted":
        if not findings:
            return verdict
        return "unexplained+named" if verdict == "unexplained" else "misnamed"
    differs = [[match(key, path, t, f) for f in findings] for t in truths]
    hits = [any(not d for d in row) for row in differs]
    extra = any(all(row[k] for row in differs) for k in range(len(findings)))
    if all(hits) and not extra:
        return "exact" if verdict == "extended" else "exact, " + verdict
    if all(hits):
        return "right+extra"
    if any(hits):
        return "half+extra" if extra else "half"
    if not findings:
        return "missed" if verdict == "adequate" else verdict
    alike = [str(f.get("indistinguishable_from") or "") for f in findings]
    if any(t["cause"] in text for t in truths for text in alike):
        return "wrong, truth among the indistinguishable"
    other = [d for row in differs for d in row if d != "cause"]
    return "wrong " + (other[0] if other else "cause")


def held_out(figures):
    """Held-out figure of an output; None without one."""
    for name in ("a90_validation_nm", "a90_validation_arcsec", "rms_validation_nm"):
        if isinstance(figures.get(name), (int, float)):
            return figures[name]
    return None


def worse_held_out(result):
    """Outputs with a held-out figure more than 2 % above the baseline's under `extended`.

    List of (output, before, after, whether its 90 % interval is wholly above).
    """
    if result["verdict"] != "extended":
        return []
    low = {}
    for finding in result["findings"]:
        for output, gain in (finding.get("gain") or {}).items():
            interval = gain.get("a90_ci90_nm") or gain.get("a90_ci90_arcsec")
            if interval:
                low[output] = interval[0]
    found = []
    for output, figures in result["baseline"].items():
        before = held_out(figures)
        after = held_out(result["extended"].get(output) or {})
        if before and after and after > 1.02 * before:
            found.append((output, before, after, low.get(output, 0) > before))
    return found
