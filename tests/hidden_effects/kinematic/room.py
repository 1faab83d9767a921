"""Temperatures of a room and of parts in it, air pressure, humidity; memory of the past."""
import math

import numpy as np


def room(rng, T, nparts):
    """Times in s, temperatures (air, parts) in degC, pressure in hPa, humidity in %; 20 s steps."""
    dt = 20.0
    pre = rng.choice([6, 14, 24]) * 3600.0
    t = np.arange(-pre, T + 2 * dt, dt)
    n = len(t)
    base = rng.uniform(19.5, 22.5)
    sup = (
        base
        + rng.uniform(0.05, 0.5) * np.sin(2 * np.pi * (t / 86400 + rng.random()))
        + rng.uniform(0, 0.08) * np.sin(2 * np.pi * (t / rng.uniform(1200, 3000) + rng.random()))
    )
    # ventilation set to another level
    for _ in range(rng.poisson(1 + T / 14400)):
        sup = sup + rng.normal(0, 0.6) * (t > rng.uniform(-min(pre, 7200), T))
    heat = np.zeros(n)
    # the operator comes and goes
    for _ in range(rng.poisson(1 + T / 10800)):
        a = rng.uniform(-3600, T)
        heat += rng.uniform(0.1, 0.5) * ((t > a) & (t < a + rng.exponential(1800)))
    wander = np.zeros(n)
    e = rng.normal(0, 1, n)
    a = math.exp(-dt / 400.0)
    w = 0
    for k in range(n):
        w = a * w + math.sqrt(1 - a * a) * e[k]
        wander[k] = w
    sup = sup + 0.03 * wander + heat
    taus = np.exp(rng.uniform(np.log(300), np.log(14000), nparts))
    tair = rng.uniform(200, 700)
    A = np.zeros((nparts + 1, nparts + 1))
    A[0, 0] = -1 / tair
    for i in range(nparts):
        A[i + 1, 0] += 1 / taus[i]
        A[i + 1, i + 1] -= 1 / taus[i]
        if i and rng.random() < 0.5:
            j = rng.integers(0, i)
            g = 0.5 / taus[i]
            A[i + 1, j + 1] += g
            A[i + 1, i + 1] -= g
    ev, U = np.linalg.eig(A)
    Ad = np.real(U @ np.diag(np.exp(ev * dt)) @ np.linalg.inv(U))
    Bd = np.linalg.solve(A, (Ad - np.eye(nparts + 1)))[:, 0] / tair
    u = np.outer(sup, Bd)
    # heat sources on parts: drives switched on near the start
    src = np.zeros(nparts + 1)
    if rng.random() < 0.5:
        src[1 + rng.integers(nparts)] = rng.uniform(0.3, 1.5)
    on = (t > rng.uniform(-1800, 0)).astype(float)
    Bh = np.linalg.solve(A, (Ad - np.eye(nparts + 1)))
    for i in range(nparts):
        if src[i + 1]:
            u = u + np.outer(on, Bh[:, i + 1]) * src[i + 1] / taus[i]
    x = np.full(nparts + 1, sup[0])
    X = np.empty((n, nparts + 1))
    for k in range(n):
        X[k] = x
        x = Ad @ x + u[k]
    p = np.cumsum(rng.normal(0, 1, n))
    p = p - p[np.searchsorted(t, 0)]
    p = rng.uniform(940, 1020) + p * rng.uniform(0.4, 1.2) / math.sqrt(3600 / dt) / 2.5
    k = 45
    p = np.convolve(np.pad(p, (k, k), "edge"), np.ones(2 * k + 1) / (2 * k + 1), "valid")
    h = 42 + 3 * np.sin(2 * np.pi * (t / 50000 + rng.random())) - 1.5 * (X[:, 0] - X[0, 0])
    return t, X, p, h


def lowpass(t, y, tau):
    """First-order lag of y, which is straight between its times."""
    out = np.empty_like(y)
    s = y[0]
    for k in range(len(t)):
        if k:
            dt = t[k] - t[k - 1]
            a = math.exp(-dt / tau)
            # exact for a straight line between samples
            r = (y[k] - y[k - 1]) / dt
            s = y[k] - r * tau + (s - y[k - 1] + r * tau) * a
        out[k] = s
    return out


def decay_sum(tm, imp, t, tau):
    """Sum of impulses at tm, each decaying with tau, at times t."""
    out = np.empty(len(t))
    s = 0.0
    last = tm[0]
    for k in range(len(t)):
        s = s * math.exp(-(tm[k] - last) / tau) + imp[k]
        last = tm[k]
        out[k] = s * math.exp(-(t[k] - tm[k]) / tau)
    return out


def dn(P, T, H):
    """Change of the refractive index of air."""
    return 2.684e-7 * (P - P[0]) - 9.3e-7 * (T - T[0]) - 8.5e-9 * (H - H[0])
