#!/usr/bin/env python3
"""The search of settings against scikit-learn over the same settings and folds, one thread each.

    bench/settings_search_peers.py [EVALUATIONS]

Runs build/dev/bin/repose_settings_search_peers (REPOSE_BIN names another folder) on its table of 185 rows and 18 inputs,
then fits the models that it tried with scikit-learn, and prints times and errors. Our time holds the search itself too.
"""
import os

for library in ('OMP', 'OPENBLAS', 'MKL', 'BLIS'):
    os.environ[library + '_NUM_THREADS'] = '1'

import json
import pathlib
import subprocess
import sys
import time
import warnings

import numpy as np
from sklearn.ensemble import BaggingRegressor, GradientBoostingRegressor
from sklearn.gaussian_process import GaussianProcessRegressor
from sklearn.gaussian_process import kernels
from sklearn.linear_model import LinearRegression
from sklearn.tree import DecisionTreeRegressor

warnings.filterwarnings('ignore')
ROOT = pathlib.Path(__file__).resolve().parent.parent
BIN = pathlib.Path(os.environ.get('REPOSE_BIN', ROOT / 'build' / 'dev' / 'bin'))


def ensemble(s):
    limits = {'min_samples_leaf': int(s['minimum_leaf']), 'max_leaf_nodes': int(s['maximum_splits']) + 1,
              'max_features': int(s['predictors'])}
    if s['method'] == 'bagging':
        return BaggingRegressor(DecisionTreeRegressor(**limits), n_estimators=int(s['trees']), random_state=1)
    return GradientBoostingRegressor(n_estimators=int(s['trees']), learning_rate=s['learning_rate'], max_depth=None,
                                     random_state=1, **limits)


class Trended:
    """A Gaussian process on the residuals of a trend; scikit-learn's own has none."""

    def __init__(self, s, scale):
        self.s, self.scale = s, scale

    def columns(self, x):
        basis = self.s['basis']
        parts = {'none': [], 'constant': [], 'linear': [x], 'quadratic': [x, x**2]}[basis]
        return np.column_stack([np.ones(len(x))] + parts)

    def fit(self, x, y):
        s = self.s
        unit = self.scale(x) if s['standardise'] == 'true' else np.ones(x.shape[1])
        ard = s['kernel'].startswith('ard-')
        shape = s['kernel'].removeprefix('ard-')
        if shape == 'rational_quadratic' or shape == 'rational-quadratic':
            base = kernels.RationalQuadratic(s['kernel_scale'], 1.0, 'fixed' if not ard else (1e-2, 1e3))
        else:
            length = np.full(x.shape[1], s['kernel_scale']) if ard else s['kernel_scale']
            bounds = (1e-2, 1e3) if ard else 'fixed'
            nu = {'exponential': 0.5, 'matern32': 1.5, 'matern52': 2.5}.get(shape)
            base = kernels.RBF(length, bounds) if nu is None else kernels.Matern(length, bounds, nu=nu)
        self.trend = None
        if s['basis'] != 'none':
            self.trend = LinearRegression(fit_intercept=False).fit(self.columns(x), y)
            y = y - self.trend.predict(self.columns(x))
        self.unit = unit
        self.gp = GaussianProcessRegressor(kernels.ConstantKernel(np.var(y) + 1e-12, (1e-10, 1e6)) * base, alpha=s['sigma']**2)
        self.gp.fit(x / unit, y)
        return self

    def predict(self, x):
        y = self.gp.predict(x / self.unit)
        return y if self.trend is None else y + self.trend.predict(self.columns(x))


def gpr(s):
    def scale(x):
        sd = x.std(axis=0, ddof=1)
        return np.where(sd > 0, sd, 1.0)
    return Trended(s, scale)


def main():
    def said(*arguments):
        return subprocess.run([BIN / 'repose_settings_search_peers', *arguments], check=True, capture_output=True,
                              text=True).stdout
    ours = json.loads(said('search', sys.argv[1] if len(sys.argv) > 1 else '50'))
    rows = [line.split(',') for line in said('table').splitlines()[1:]]
    x = np.array([[float(value) for value in row[:-2]] for row in rows])
    y = np.array([float(row[-1]) for row in rows])
    folds = np.array(ours['folds'])
    for name, make in (('ensemble', ensemble), ('gpr', gpr)):
        trials = ours[name]['trials']
        start = time.perf_counter()
        errors = []
        for trial in trials:
            square = 0.0
            for f in range(folds.max() + 1):
                model = make(trial['settings']).fit(x[folds != f], y[folds != f])
                square += ((model.predict(x[folds == f]) - y[folds == f])**2).sum()
            errors.append((square / len(y))**0.5)
        theirs = time.perf_counter() - start
        both = [(t['rmse'], e) for t, e in zip(trials, errors) if not t['failure']]
        our_errors, errors = np.array(both).T
        print(f'{name}: {len(trials)} settings, five folds: repose {ours[name]["seconds"]:.2f} s with its search, '
              f'scikit-learn {theirs:.1f} s, ratio {theirs / ours[name]["seconds"]:.0f}')
        print(f'  smallest error: repose {min(our_errors):.4g}, scikit-learn {min(errors):.4g}; median ratio of errors '
              f'{np.median(our_errors / errors):.3f}', flush=True)


if __name__ == '__main__':
    main()
