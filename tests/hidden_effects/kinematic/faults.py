"""Causes that change a reading instead of the pose: a thermometer's fault, a change of spread."""
import numpy as np

from baseline import Bad, base_cols, motor, white


def sensor_fault(rng, S, target):
    """Faulty readings (n,parts) and the truth. The strength is what the faulty column leaves."""
    k = int(rng.choice(S.bs))
    row = int(rng.integers(int(0.2 * S.n), int(0.7 * S.n)))
    mode = rng.choice(["jump", "freeze"])
    after = np.arange(S.n) >= row
    e = after.astype(float) if mode == "jump" else -(S.T[:, k] - S.Tf[row, k]) * after
    Tfile = S.Tf.copy()
    if mode == "jump":
        size = 0.01
        while left_by_fault(S, k, size * e) < target and size < 30:
            size *= 1.25
        if size >= 1.5 or size < 8 * S.sT:
            raise Bad("fault size")
        got = left_by_fault(S, k, size * e)
        Tfile[row:, k] = np.round(S.Tf[row:, k] + size, 4)
        pars = {"mode": "jump", "size_K": size}
    else:
        got = left_by_fault(S, k, 1.0 * e)
        Tfile[row:, k] = S.Tf[row, k]
        pars = {"mode": "freeze"}
        if got < 60 or got > 800:
            raise Bad("fault chi2 %g" % got)
    truth = {
        "cause": "sensor_fault",
        "subject": S.Tname[k],
        "parameters": {"time_s": float(S.t[row]), **pars},
        "chi2": got,
    }
    return Tfile, truth


def left_by_fault(S, k, error):
    """chi2 that is left when the baseline has the faulty column, with coefficients of its own."""
    T = S.T.copy()
    T[:, k] = S.T[:, k] + error
    B = base_cols(S, S.deg, T=T)
    M = np.concatenate([white(S, motor(S, B, i)) for i in range(S.robot.d)], 1)
    M /= np.linalg.norm(M, axis=0)
    Q, _ = np.linalg.qr(M)
    share = np.outer(S.T[:, k] - S.T[0, k], S.coef[S.bs.index(k)])
    w = white(S, np.einsum("nij,nj->ni", S.Ji, share)[:, :, None])
    w = w - Q @ (Q.T @ w)
    return float((w**2).sum())


def noise_change(rng, S, target):
    """Spread of one pose axis grows from a row on; the strength is 2 ln L of the change."""
    if S.noise != "white":
        raise Bad("white only")
    j = int(rng.integers(S.robot.d))
    row = int(rng.integers(int(0.3 * S.n), int(0.7 * S.n)))
    m = np.arange(S.n) >= row
    m1 = int((m & S.cal).sum())
    m0 = int(S.cal.sum()) - m1
    for ratio in np.exp(np.linspace(np.log(1.2), np.log(6), 60)):
        mean = (m0 + m1 * ratio**2) / (m0 + m1)
        got = (m0 + m1) * np.log(mean) - m1 * np.log(ratio**2)
        if got >= target:
            break
    if ratio > 5:
        raise Bad("ratio")
    S.eps[m, j] *= ratio
    return {
        "cause": "noise_change",
        "subject": S.robot.pose[j],
        "parameters": {"time_s": float(S.t[row]), "ratio": float(ratio)},
        "chi2": float(got),
    }
