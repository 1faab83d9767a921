"""Data set with something hidden: strength, identifiability and the key that says what it is."""
import math

import numpy as np

from baseline import Bad, base_cols, file_cols, formula, proj, set_basis, white
from causes import CAUSES, ONLY, WANT, hide
from dataset import base_set
from faults import noise_change, sensor_fault
from noise import NOISES, motor_sigma, quantise
from plans import PLANS
from rivals import alias, explained, rivals, whiten_rivals
from robots import ROBOTS
from unlisted import UNLISTED, unlisted

ATTEMPTS = 40
# From this attempt on a data set is accepted although another cause comes near.
LAST_RESORT = 34
# A rival is near within this much of 2 ln L.
NEAR = 20
# Causes whose column is worked out from the file: it must explain the effect too.
FROM_FILE = (
    "thermal_offset",
    "thermal_lag",
    "thermal_rate",
    "thermal_expansion",
    "self_heating",
    "activity_heating",
    "backlash",
    "refractive_index",
    "instrument_drift",
)
NOT_IN_PAIRS = ("sensor_fault", "noise_change", "gear_error", "probe_hysteresis")


def drawn_causes(kind, index, attempt, cause):
    """Causes to hide; None where an attempt has the same cause twice."""
    if kind == "single":
        return [cause or CAUSES[index % len(CAUSES)]]
    if kind == "pair":
        pool = [c for c in CAUSES if c not in NOT_IN_PAIRS]
        cs = [pool[index % len(pool)], pool[(index * 5 + 7 + attempt) % len(pool)]]
        return cs if cs[0] != cs[1] else None
    if kind == "unlisted":
        return [cause or UNLISTED[index % len(UNLISTED)]]
    return []


def wanted(causes):
    """What the data set must have."""
    want = {}
    for c in causes:
        want.update(WANT.get(c, {}))
    if len(causes) == 1:
        want["cause"] = causes[0]
    elif "force_compliance" in causes:
        want["cause"] = "force_compliance"
    elif "thermal_expansion" in causes:
        want["cause"] = "thermal_expansion"
    return want


def pose_effect(S, H, a):
    """Effect of size a in the poses (n,d)."""
    V = H["v"] * a
    return np.einsum("nij,nj->ni", S.Ji, V) if H["side"] == "q" else V


def chi2(S, H, a):
    V = pose_effect(S, H, a)
    w = white(S, V[:, :, None])
    return float((proj(S, w) ** 2).sum()), V


def chi2_per_output(S, H):
    """chi2 of the effect of size 1 when each motor is fitted alone, as if its noise were white."""
    Vq = np.einsum("nij,nj->ni", S.J, pose_effect(S, H, 1.0))[S.cal]
    total = 0.0
    for i in range(S.robot.d):
        si = motor_sigma(S, i)
        B = base_cols(S, S.deg)[S.cal] / si[:, None]
        y = Vq[:, i] / si
        co, *_ = np.linalg.lstsq(B, y, rcond=None)
        total += float(((y - B @ co) ** 2).sum())
    return total


def nearest(S, cause, subject, gaps):
    """Rivals by their gap in 2 ln L; the same thing in another word is none."""
    left = [
        (e, k)
        for k, e in gaps.items()
        if not alias(S, cause, subject, *k)
        and cause != "outliers"
        and not (cause == "force_compliance" and k[0].startswith("force"))
    ]
    return sorted(left, key=lambda z: z[0])


def hide_cause(rng, S, cause, target, catalogue):
    """Pose effect (n,d) of a listed cause of strength `target`, and what the key says of it."""
    H = hide(rng, S, cause)
    c1, _ = chi2(S, H, 1.0)
    if not c1 > 0:
        raise Bad("empty")
    cm = chi2_per_output(S, H)
    # the weaker of the two strengths is the wanted one
    a = math.sqrt(target / min(c1, cm))
    cm *= a * a
    if not H["limit"][0] <= a <= H["limit"][1]:
        raise Bad("size %g" % a)
    got, V = chi2(S, H, a)
    raw = white(S, V[:, :, None])
    least = 0.003 if "thermal" in cause or cause == "instrument_drift" else 0.01
    if got < least * float((raw**2).sum()) and cause != "thermal_lag":
        raise Bad("nearly in the baseline")
    v = proj(S, raw)[:, 0]
    gaps = {}
    for c, s, w in catalogue():
        e = got - explained(w, v)
        if (c, s) not in gaps or e < gaps[(c, s)]:
            gaps[(c, s)] = e
    near = nearest(S, cause, H["subject"], gaps)
    own = gaps.get((cause, H["subject"]))
    identifiable = not near or near[0][0] > NEAR
    if cause in FROM_FILE and (own is None or own > 0.2 * got + 3):
        identifiable = False
    return V, {
        "cause": cause,
        "subject": H["subject"],
        "side": H["side"],
        "parameters": H["par"](a),
        "chi2": got,
        "chi2_per_output_white": cm,
        "own_gap": own,
        "identifiable": bool(identifiable),
        "nearest": [[k[0], k[1], round(e, 1)] for e, k in near[:3]],
        "rms_sigma": float(np.sqrt(((V / S.sigma) ** 2).mean(0)).max()),
    }


def hide_unlisted(rng, S, kind, target, catalogue, last_resort):
    H = unlisted(rng, S, kind)
    c1, _ = chi2(S, H, 1.0)
    if not c1 > 0:
        raise Bad("empty")
    got, V = chi2(S, H, math.sqrt(target / c1))
    raw = white(S, V[:, :, None])
    if got < 0.02 * float((raw**2).sum()):
        raise Bad("nearly in the baseline")
    v = proj(S, raw)[:, 0]
    near = sorted((got - explained(w, v), c, s) for c, s, w in catalogue())
    if near[0][0] < 0.5 * got and not last_resort:
        raise Bad("a catalogue entry explains half: %s" % (near[0],))
    return V, {
        "cause": H["cause"],
        "subject": H["subject"],
        "chi2": got,
        "nearest": [[c, s, round(e, 1)] for e, c, s in near[:3]],
    }


def catalogue_of(S):
    """Function that lists the whitened rivals (cause, subject, columns), computed at first use."""
    made = []

    def catalogue():
        if not made:
            R = rivals(S)
            made.extend((c, s, w) for (c, s, _), w in zip(R, whiten_rivals(S, R)))
        return made

    return catalogue


def hide_all(rng, S, kind, causes, last_resort, key):
    """Hides the causes: pose effect (n,d) and thermometers as the file has them. Fills the key."""
    target = float(rng.choice([75, 150, 300]))
    effect, Tfile = np.zeros((S.n, S.robot.d)), S.Tf.copy()
    catalogue = catalogue_of(S)
    identifiable = True
    key["truth"] = []
    if causes == ["sensor_fault"]:
        Tfile, truth = sensor_fault(rng, S, target)
        key["truth"] = [truth]
        target = truth["chi2"]
        key["ident_note"] = "seen in the thermometer itself"
    elif causes == ["noise_change"]:
        key["truth"] = [noise_change(rng, S, target)]
    elif kind == "unlisted":
        target = float(rng.choice([150, 300, 600]))
        effect, truth = hide_unlisted(rng, S, causes[0], target, catalogue, last_resort)
        key["truth"] = [truth]
    else:
        for c in causes:
            V, truth = hide_cause(rng, S, c, target, catalogue)
            key["truth"].append(truth)
            identifiable = identifiable and truth["identifiable"]
            effect = effect + V
            if c == "geometry_order":
                key["note"] = "degree %d needed" % (S.deg + 1)
        if not identifiable and not last_resort:
            raise Bad("not identifiable %s" % key["truth"][-1]["nearest"])
    key.update(identifiable=identifiable, target=target)
    return effect, Tfile


def thermometers_all_in_baseline(S):
    rest = [a for a in range(S.nparts) if a not in S.bs]
    S.coef = np.vstack([S.coef, np.repeat(S.coef[:1] * 0, len(rest), 0)])
    S.bs = S.bs + rest


def build(seed, kind, index, robot=None, plan=None, noise=None, cause=None):
    """Data set, its measured poses and thermometers, its key; None, None, reason if none fits."""
    names = list(ROBOTS)
    why = ""
    for attempt in range(ATTEMPTS):
        rng = np.random.default_rng([seed, attempt, 77])
        rb = robot or names[(index + attempt * 3) % len(names)]
        pl = plan or PLANS[(index * 3 + index // 8 + attempt * 7) % len(PLANS)]
        ns = noise or NOISES[(index + index // 4 + index // 8) % 4]
        causes = drawn_causes(kind, index, attempt, cause)
        if causes is None:
            continue
        if causes == ["noise_change"]:
            ns = noise or "white"
        for c in causes:
            if c in ONLY and rb not in ONLY[c]:
                rb = ONLY[c][(index // len(CAUSES) + attempt) % len(ONLY[c])]
        key = {"kind": kind, "seed": seed, "attempt": attempt}
        try:
            S = base_set(rng, rb, pl, ns, wanted(causes))
            if "thermal_expansion" in causes and len(S.bs) < S.nparts:
                thermometers_all_in_baseline(S)
            set_basis(S)
            effect, Tfile = hide_all(rng, S, kind, causes, attempt >= LAST_RESORT, key)
        except Bad as e:
            why = str(e)
            continue
        pm = S.p0 + effect + S.eps
        quantise(S, pm)
        describe(S, key, rb, pm, effect, Tfile)
        return S, (pm, Tfile), key
    return None, None, why


def describe(S, key, family, pm, effect, Tfile):
    """Completes the key, with chi2 per degree of freedom of what the truth and the file leave."""
    r = S.robot
    e = pm - S.p0 - effect
    w = proj(S, white(S, e[:, :, None]))
    dof = len(w) - S.Q.shape[1]
    truth = {name: key.pop(name) for name in ("identifiable", "target")}
    key.update(
        robot=r.name,
        family=family,
        plan=S.plan,
        noise=S.noise,
        noise_par=S.npar,
        rows=S.n,
        cal=int(S.cal.sum()),
        split=S.split,
        span_s=float(S.t[-1] - S.t[0]),
        stroke_mm=float(2 * r.half[0]),
        sigma=[float(s) for s in S.sigma],
        degree=S.deg,
        misfit_chi2=S.misfit,
        baseline=formula(S, S.deg),
        **truth,
        chi2_dof_truth=float((w**2).sum()) / dof,
        chi2_dof_file=[chi2_dof_of_motor(S, i, file_cols(S, pm, Tfile)) for i in range(r.d)],
    )


def chi2_dof_of_motor(S, i, columns):
    """chi2 per degree of freedom of motor i over the file's columns, as if noise were white."""
    y = S.q[S.cal, i]
    si = motor_sigma(S, i)
    A = columns[S.cal] / si[:, None]
    co, *_ = np.linalg.lstsq(A, y / si, rcond=None)
    rest = y / si - A @ co
    return float((rest**2).sum()) / (len(y) - A.shape[1])
