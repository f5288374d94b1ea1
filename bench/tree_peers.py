#!/usr/bin/env python3
"""Bagging and boosting against scikit-learn: measures and writes the part `trees` of docs/validation/zoo.md.

Run by scripts/validate_trees. Both sides get the same rows and the same ten folds and one thread; they are measured in
turn, seed after seed, and the page shows medians.
"""
import os

for library in ('OMP', 'OPENBLAS', 'MKL', 'BLIS'):
    os.environ[library + '_NUM_THREADS'] = '1'

import argparse
import json
import pathlib
import platform
import re
import statistics
import subprocess
import sys
import time

import numpy as np
import sklearn
from sklearn.ensemble import (BaggingRegressor, GradientBoostingRegressor, HistGradientBoostingRegressor,
                              RandomForestRegressor)

ROOT = pathlib.Path(__file__).resolve().parent.parent
PAGE = ROOT / 'docs' / 'validation' / 'zoo.md'
KINDS = {'screening': '185 rows of five screening designs, 18 inputs of 2 to 3 levels',
         'uniform': '185 rows of 18 uniform inputs'}
PEERS = {
    'bag': {
        'BaggingRegressor': lambda seed: BaggingRegressor(n_estimators=100, random_state=seed),
        'RandomForestRegressor': lambda seed: RandomForestRegressor(n_estimators=100, random_state=seed),
    },
    'boosting': {
        'GradientBoostingRegressor': lambda seed: GradientBoostingRegressor(
            n_estimators=100, max_depth=4, criterion='squared_error', random_state=seed),
        'HistGradientBoostingRegressor': lambda seed: HistGradientBoostingRegressor(
            max_iter=100, max_depth=4, min_samples_leaf=1, early_stopping=False, random_state=seed),
    },
}


def smallest(call):
    least, spent = float('inf'), 0.0
    while spent < 0.05:
        start = time.perf_counter()
        call()
        seconds = time.perf_counter() - start
        least, spent = min(least, seconds), spent + seconds
    return least


def peer(model_of, seed, fold, x, y):
    seconds, squares = 0.0, 0.0
    for f in range(10):
        model = model_of(seed)
        train, test = fold != f, fold == f
        start = time.perf_counter()
        model.fit(x[train], y[train])
        seconds += time.perf_counter() - start
        squares += float(np.sum((model.predict(x[test]) - y[test]) ** 2))
    model = model_of(seed).fit(x, y)
    many = x[np.arange(10000) % len(y)]
    return {'fit_seconds': seconds, 'rmse': (squares / len(y)) ** 0.5,
            'predict_185': smallest(lambda: model.predict(x)),
            'predict_10000': smallest(lambda: model.predict(many))}


def measure(program, seeds):
    results = {}
    for kind in KINDS:
        for seed in range(1, seeds + 1):
            text = subprocess.run([program, 'table', kind, str(seed)], capture_output=True, text=True, check=True).stdout
            table = np.array([[float(v) for v in line.split(',')] for line in text.splitlines()])
            fold, y, x = table[:, 0], table[:, 1], table[:, 2:]
            for model, peers in PEERS.items():
                ours = subprocess.run([program, 'run', kind, str(seed), model], capture_output=True, text=True,
                                      check=True).stdout
                results.setdefault((kind, model, 'repose'), []).append(json.loads(ours))
                for name, model_of in peers.items():
                    results.setdefault((kind, model, name), []).append(peer(model_of, seed, fold, x, y))
            print(f'{time.strftime("%H:%M:%S")} {kind}, seed {seed} of {seeds}', file=sys.stderr, flush=True)
    return results


def median(runs, figure):
    return statistics.median(run[figure] for run in runs)


def spread(runs, figure):
    values = [run[figure] for run in runs]
    return f'{statistics.mean(values):.4f} ± {statistics.stdev(values):.4f}'


def page(results, seeds):
    lines = [f'{platform.machine()}, {os.cpu_count()} processors, load {os.getloadavg()[0]:.1f} while it ran; '
             f'scikit-learn {sklearn.__version__}, one thread on both sides; {seeds} seeds in turn, medians of times and',
             'mean ± standard deviation of errors over seeds. "×" is the time of the other over ours.', '',
             '| table | model | program | RMSE in ten folds | fit, ten folds, ms | × | predict 185 rows, µs | × | '
             'predict 10,000 rows, µs a row | × |',
             '|---|---|---|---|---|---|---|---|---|---|']
    for kind, title in KINDS.items():
        for model, peers in PEERS.items():
            ours = results[kind, model, 'repose']
            for name in ('repose', *peers):
                runs = results[kind, model, name]
                cells = [title, '100 trees bagged' if model == 'bag' else '100 trees of depth 4 boosted', name,
                         spread(runs, 'rmse')]
                for figure, scale, form in (('fit_seconds', 1e3, '.1f'), ('predict_185', 1e6, '.0f'),
                                            ('predict_10000', 1e2, '.3f')):
                    value = median(runs, figure)
                    ratio = '' if name == 'repose' else f'{value / median(ours, figure):.1f}'
                    cells += [format(value * scale, form), ratio]
                lines.append('| ' + ' | '.join(cells) + ' |')
    return '\n'.join(lines)


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument('--program', required=True)
    parser.add_argument('--seeds', type=int, default=7)
    options = parser.parse_args()
    text = page(measure(options.program, options.seeds), options.seeds)
    part = re.compile(r'(<!-- trees: written by bench/tree_peers.py -->\n).*?(\n?<!-- end -->)', re.S)
    old = PAGE.read_text()
    if not part.search(old):
        sys.exit(f'{PAGE} has no part for trees')
    PAGE.write_text(part.sub(lambda match: match.group(1) + text + match.group(2), old))
    print(text)


main()
