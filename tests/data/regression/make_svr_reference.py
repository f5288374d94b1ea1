#!/usr/bin/env python3
"""Writes svr_train.csv and svr_reference.csv: support vector regressions by scikit-learn, which wraps LIBSVM
itself, of data scaled as SupportVectorRegression::fit does. Run with scikit-learn 1.2.1 and numpy 1.24."""
import numpy as np
from sklearn.svm import SVR

random = np.random.default_rng(7)
x = random.uniform(size=(60, 3))
y = 10 * np.sin(3 * x[:, 0]) + 4 * x[:, 1] * x[:, 2] + 0.3 * random.normal(size=60)
new = random.uniform(size=(12, 3))

z = (x - x.mean(axis=0)) / x.std(axis=0, ddof=1)
z_new = (new - x.mean(axis=0)) / x.std(axis=0, ddof=1)
low, high = np.percentile(y, [25, 75], method="hazen")
scale = (high - low) / 1.349
target = (y - y.mean()) / scale

columns = [new[:, 0], new[:, 1], new[:, 2]]
names = ["x1", "x2", "x3"]
for name, kernel, degree, s in (("linear", "linear", 1, 1.0), ("quadratic", "poly", 2, 1.0),
                                ("cubic", "poly", 3, 1.0), ("fine_gaussian", "rbf", 1, 0.25),
                                ("medium_gaussian", "rbf", 1, 1.0), ("coarse_gaussian", "rbf", 1, 4.0)):
    s *= np.sqrt(3.0)
    model = SVR(kernel=kernel, degree=degree, gamma=1.0, coef0=1.0, C=1.0, epsilon=0.1, tol=1e-6)
    model.fit(z / s, target)
    columns.append(y.mean() + scale * model.predict(z_new / s))
    names.append(name)
np.savetxt("svr_train.csv", np.column_stack([x, y]), delimiter=",", header="x1,x2,x3,y", comments="", fmt="%.17g")
np.savetxt("svr_reference.csv", np.column_stack(columns), delimiter=",", header=",".join(names), comments="",
           fmt="%.17g")
