"""Smoothing splines and a small neural net beside a polynomial, on a joined dataset: the study's statement that all
identification methods reach the same accuracy and that the measurements matter. Outside the daemon's core on purpose.

usage: other_methods.py DATASET.csv [DATASET_WITH_TRUE_VALIDATION_ROWS.csv]

Every method sees the calibration rows and is judged on the same validation rows. What has to be chosen (the spline's smoothing,
the net's size and its number of steps) is chosen on every fifth calibration row, never on the validation rows.
"""
import csv
import sys
import time

import numpy


def read(path):
    with open(path, newline="") as file:
        rows = [row for row in csv.reader(line for line in file if not line.startswith("#"))]
    name = {column: i for i, column in enumerate(rows[0])}
    inputs, outputs, validation = [], [], []
    for row in rows[1:]:
        cells = [row[name[c]] for c in ("x_mm", "y_mm", "z_mm", "q1_mm", "q2_mm", "q3_mm")]
        marks = [row[name[mark]] for mark in ("excluded", "suspect", "passage") if mark in name]
        if "" in cells or "1" in marks:
            continue
        values = [float(cell) for cell in cells]
        inputs.append(values[:3])
        outputs.append(values[3:])
        validation.append(row[name["set"]] == "validation")
    return numpy.array(inputs), numpy.array(outputs), numpy.array(validation)


def monomials(x, degree):
    columns = [numpy.ones(len(x))]
    for i in range(degree + 1):
        for j in range(degree + 1 - i):
            for k in range(degree + 1 - i - j):
                if i + j + k > 0:
                    columns.append(x[:, 0] ** i * x[:, 1] ** j * x[:, 2] ** k)
    return numpy.column_stack(columns)


class Polynomial:
    def __init__(self, degree):
        self.degree = degree

    def fit(self, x, y):
        self.coefficients = numpy.linalg.lstsq(monomials(x, self.degree), y, rcond=None)[0]
        self.parameters = self.coefficients.size
        return self

    def predict(self, x):
        return monomials(x, self.degree) @ self.coefficients


class ThinPlate:
    """Smoothing spline of order 3 in space: sum of |x - x_i|^3 and a quadratic (Wahba, Spline Models, 1990)."""

    def __init__(self, smoothing):
        self.smoothing = smoothing

    def fit(self, x, y):
        self.nodes, n = x, len(x)
        kernel = numpy.linalg.norm(x[:, None] - x[None], axis=2) ** 3 + n * self.smoothing * numpy.eye(n)
        flat = monomials(x, 2)
        whole = numpy.block([[kernel, flat], [flat.T, numpy.zeros((10, 10))]])
        # Returns to zero repeat a place: without smoothing only least squares has an answer.
        self.weights = numpy.linalg.lstsq(whole, numpy.vstack([y, numpy.zeros((10, y.shape[1]))]), rcond=None)[0]
        self.parameters = self.weights.size
        return self

    def predict(self, x):
        kernel = numpy.linalg.norm(x[:, None] - self.nodes[None], axis=2) ** 3
        return numpy.column_stack([kernel, monomials(x, 2)]) @ self.weights


class Net:
    """One hidden layer of tanh beside a linear part, by Levenberg and Marquardt's method with weight decay."""

    def __init__(self, hidden, steps, seed=1):
        self.hidden, self.steps, self.seed = hidden, steps, seed

    def forward(self, w, x):
        h = self.hidden
        inner = numpy.tanh(x @ w[: 3 * h].reshape(3, h) + w[3 * h : 4 * h])
        return inner, inner @ w[4 * h : 5 * h] + w[5 * h] + x @ w[5 * h + 1 :]

    def fit(self, x, y):
        self.scale = numpy.abs(x).max()
        u, random, h = x / self.scale, numpy.random.default_rng(self.seed), self.hidden
        self.nets, self.parameters = [], 0
        for column in y.T:
            middle, spread = column.mean(), column.std()
            wanted = (column - middle) / spread
            w = random.normal(0, 0.5, 5 * h + 4)
            damping, decay = 1e-2, 1e-12
            inner, out = self.forward(w, u)
            cost = ((wanted - out) ** 2).sum() + decay * (w**2).sum()
            for _ in range(self.steps):
                slope = (1 - inner**2) * w[4 * h : 5 * h]
                jacobian = numpy.column_stack(
                    [(u[:, :, None] * slope[:, None, :]).reshape(len(u), 3 * h), slope, inner, numpy.ones(len(u)), u])
                normal = jacobian.T @ jacobian
                gradient = jacobian.T @ (wanted - out) - decay * w
                while damping < 1e12:
                    step = numpy.linalg.solve(normal + (damping + decay) * numpy.eye(len(w)), gradient)
                    inner_new, out_new = self.forward(w + step, u)
                    cost_new = ((wanted - out_new) ** 2).sum() + decay * ((w + step) ** 2).sum()
                    if cost_new < cost:
                        break
                    damping *= 4
                if damping >= 1e12:
                    break
                w, inner, out, cost, damping = w + step, inner_new, out_new, cost_new, max(damping / 3, 1e-12)
            self.nets.append((w, middle, spread))
            self.parameters += len(w)
        return self

    def predict(self, x):
        return numpy.column_stack([m + s * self.forward(w, x / self.scale)[1] for w, m, s in self.nets])


def a90_nm(errors_mm):
    return 1.645e6 * numpy.sqrt((errors_mm**2).mean(axis=0))


def chosen(candidates, x, y):
    inner = numpy.arange(len(x)) % 5 == 0
    scores = [(a90_nm(make().fit(x[~inner], y[~inner]).predict(x[inner]) - y[inner]).mean(), i)
              for i, make in enumerate(candidates)]
    return candidates[min(scores)[1]]


def main():
    x, y, validation = read(sys.argv[1])
    truth = read(sys.argv[2]) if len(sys.argv) > 2 else None
    methods = {
        "polynomial": [lambda d=d: Polynomial(d) for d in (2, 3, 4, 5)],
        "smoothing spline": [lambda s=s: ThinPlate(s) for s in (0, 1e-5, 1e-4, 1e-3, 1e-2)],
        "small neural net": [lambda h=h, n=n: Net(h, n) for h in (4, 8, 12) for n in (50, 200)],
    }
    print(f"{(~validation).sum()} calibration rows, {validation.sum()} validation rows; A90 in nm of q1, q2, q3")
    print(f"  {'':18}{'parameters':>11}{'time, s':>9}   {'instruments':<24}{'truth' if truth else ''}")
    for name, candidates in methods.items():
        begun = time.monotonic()
        model = chosen(candidates, x[~validation], y[~validation])().fit(x[~validation], y[~validation])
        spent = time.monotonic() - begun
        figures = [a90_nm(model.predict(x[validation]) - y[validation])]
        if truth:
            figures.append(a90_nm(model.predict(truth[0][truth[2]]) - truth[1][truth[2]]))
        texts = [" ".join(f"{value:7.1f}" for value in one) for one in figures]
        print(f"  {name:18}{model.parameters:11d}{spent:9.2f}   " + "   ".join(texts))


main()
