#!/usr/bin/env python3
"""The Gaussian process against scikit-learn and OpenTURNS: measures and writes docs/validation/gp.md.

Run by scripts/validate_gp. Every stage keeps its results in build/gp_validation/STAGE.json, so that a rerun redoes
only what is named (or missing); figures of repose are measured anew whenever its program changed.
"""
import os

for library in ('OMP', 'OPENBLAS', 'MKL', 'BLIS'):
    os.environ[library + '_NUM_THREADS'] = '1'

import argparse
import csv
import hashlib
import json
import math
import pathlib
import subprocess
import sys
import time

import numpy as np

import gaussian_process_page as page
from gaussian_process_problems import ACCURACY, HELD_OUT, SPEED, Problem, negative_log_likelihoods
from gaussian_process_sides import (Failure, Repose, limited, openturns_fit, openturns_predict, sklearn_fit,
                                    sklearn_predict)

ROOT = pathlib.Path(__file__).resolve().parent.parent
DATA = ROOT / 'tests' / 'data' / 'gp'
CACHE = ROOT / 'build' / 'gp_validation'
DESIGNS = 20
STARTS = 5
MATCHED = {'estimator': 'ml', 'prior': 'none', 'noise': 'estimated', 'basis': 'constant', 'parameter_uncertainty': 'ignored'}


def say(text):
    print(f'{time.strftime("%H:%M:%S")} {text}', file=sys.stderr, flush=True)


def stored(stage):
    file = CACHE / f'{stage}.json'
    return json.loads(file.read_text()) if file.exists() else {}


def store(stage, value):
    CACHE.mkdir(parents=True, exist_ok=True)
    part = CACHE / f'{stage}.part'
    part.write_text(json.dumps(value, indent=1))
    part.replace(CACHE / f'{stage}.json')


def load():
    return round(os.getloadavg()[0], 2)


def provenance():
    def git(*arguments):
        return subprocess.run(['git', '-C', str(ROOT), *arguments], capture_output=True, text=True).stdout.strip()
    changed = git('status', '--porcelain', '--untracked-files=no', 'lib*', 'bench')
    return {'date': time.strftime('%Y-%m-%d %H:%M UTC', time.gmtime()), 'load': load(),
            'commit': git('rev-parse', '--short', 'HEAD') + (' and changes' if changed else '')}


def median(values):
    return float(np.median(values))


# ---- correctness -------------------------------------------------------------------------------

def relative(found, expected):
    """Of single numbers, each with its own size."""
    found, expected = np.atleast_1d(found), np.atleast_1d(expected)
    return float(max(abs(found - expected) / np.where(expected == 0, 1.0, abs(expected))))


def references(repose, _):
    """40 cases: likelihood, coefficients, mean, standard deviation; 9 expected improvements."""
    reference = json.loads((DATA / 'gp_reference.json').read_text())
    names = {'exponential': 'exponential', 'matern32': 'matern32', 'matern52': 'matern52',
             'squaredexponential': 'squared-exponential', 'rationalquadratic': 'rational-quadratic'}
    x, y = np.array(reference['U']), np.array(reference['y'])
    worst = {'likelihood': 0.0, 'coefficients': 0.0, 'mean': 0.0, 'sd': 0.0, 'ei': 0.0}

    def keep(what, error):
        worst[what] = max(worst[what], error)
    for c in reference['cases']:
        given = repose.fit_given(x, y, kernel='ard-' + names[c['kernel']], estimator='ml',
                                 basis={'pureQuadratic': 'quadratic'}.get(c['basis'], c['basis']),
                                 length_scales=c['length_scales'], process_variance=c['sigma_f'] ** 2,
                                 noise_variance=c['sigma_n'] ** 2, alpha=c['rq_alpha'] or 1.0)
        keep('likelihood', relative(-given['negative_log_likelihood'], c['log_likelihood_profile_beta']))
        if c['beta']:
            beta = np.array(c['beta'])
            keep('coefficients', float(max(abs(np.array(given['coefficients']) - beta)) / max(abs(beta))))
        mean, sd, _ = repose.predict(np.array(reference['U_test']))
        keep('mean', relative(mean, c['mean']))
        keep('sd', relative(sd, c['sd_latent_with_beta_uncertainty']))
    for e in reference['expected_improvement']:
        found = repose.ask(op='ei', mean=e['mu'], sd=e['sigma'], best=e['f_min'])['value']
        keep('ei', relative(found, e['ei']))
    return {'cases': len(reference['cases']), 'improvements': len(reference['expected_improvement']), 'worst': worst}


SETS = [('Branin, 20 points', 'ds_branin_10d.csv', 2, 87.2227), ('borehole, 80', 'ds_borehole_10d.csv', 8, 136.4567),
        ('welded beam, 40', 'ds_weldedbeamdesign_10d.csv', 4, 122.7286), ('g10mod, 40', 'ds_g10mod_5d.csv', 8, 133.825)]


def likelihoods(repose, _):
    """Best known likelihoods, and the same in other units."""
    rows = []
    for name, file, d, best in SETS:
        with open(DATA / file) as stream:
            table = np.array([[float(v) for v in row[1:]] for row in list(csv.reader(stream))[1:]])
        x, y = table[:, :d], table[:, d]

        def value(cx, cy):
            scaled = cx * x
            fit = repose.ask(op='fit', x=scaled.tolist(), y=(cy * y).tolist(), lower=scaled.min(axis=0).tolist(),
                             upper=scaled.max(axis=0).tolist(), estimator='ml', prior='none', noise='none', starts=STARTS)
            return fit['negative_log_likelihood'] - len(y) * math.log(cy), fit['evaluations']
        plain, evaluations = value(1.0, 1.0)
        rows.append({'name': name, 'd': d, 'best': best, 'value': plain, 'evaluations': evaluations,
                     'binary': max(abs(value(1.0, 1024.0)[0] - plain), abs(value(1024.0, 1.0)[0] - plain)),
                     'decimal': max(abs(value(1.0, 1e3)[0] - plain), abs(value(1e3, 1.0)[0] - plain))})
    return rows


# ---- time --------------------------------------------------------------------------------------

def add_likelihoods(kernel, problem, fits):
    known = {}  # most fits are the same again
    for f in fits:
        key = json.dumps([f[k] for k in ('length_scales', 'process_variance', 'noise_variance')])
        if key not in known:
            known[key] = negative_log_likelihoods(kernel, problem.x, problem.y, np.array(f['length_scales']),
                                                  f['process_variance'], f['noise_variance'])
        f.update(known[key])


def timed_fits(kernel, problem, ours, theirs, rounds=5):
    """Alternates; then both likelihoods by one function."""
    rows = []
    for i in range(rounds):
        row = {'load': load(), 'repose': ours(), 'sklearn': theirs(i)}
        say(f"  {i + 1}: repose {row['repose']['seconds']:.3f} s, scikit-learn {row['sklearn']['seconds']:.2f} s, load {row['load']}")
        rows.append(row)
    add_likelihoods(kernel, problem, [r[side] for r in rows for side in ('repose', 'sklearn')])
    return {'rows': rows, 'ratio': median([r['sklearn']['seconds'] for r in rows]) / median([r['repose']['seconds'] for r in rows])}


def fit185(repose, _):
    """185 points, 18 inputs, squared exponential; scikit-learn as it restarts itself, bounds wide."""
    problem = Problem(SPEED['smooth18'], True, 1)
    kernel = 'squared-exponential'

    def ours():
        return repose.fit(problem.x, problem.y, kernel='ard-' + kernel, starts=STARTS, **MATCHED)
    ours()
    sklearn_fit(kernel, problem.x[:60], problem.y[:60], 0)
    return timed_fits(kernel, problem, ours, lambda i: sklearn_fit(kernel, problem.x, problem.y, STARTS - 1, seed=i)[1])


def same_starts(repose, n, count):
    problem = Problem(SPEED['borehole'], False, 1, n)

    def ours(**more):
        return repose.fit(problem.x, problem.y, kernel='ard-matern52', starts=count, **MATCHED, **more)
    starts = ours(show_starts=True)['starts']
    sklearn_fit('matern52', problem.x[:60], problem.y[:60], 0)
    return timed_fits('matern52', problem, ours, lambda i: sklearn_fit('matern52', problem.x, problem.y, 0, starts=starts)[1])


def fit200(repose, _):
    """Borehole, 200 points, Matérn 5/2, five same starts."""
    return same_starts(repose, 200, STARTS)


def fit1000(repose, _):
    """Borehole, 1000 points, Matérn 5/2, one same start."""
    return same_starts(repose, 1000, 1)


def predict(repose, _):
    """Mean and standard deviation of the function at 100,000 points, both at scikit-learn's parameters."""
    problem = Problem(SPEED['borehole'], False, 1)
    points = np.random.default_rng(3).random((100_000, problem.function.d))
    results = {}
    for kernel in ('matern52', 'squared-exponential'):
        model, fitted = sklearn_fit(kernel, problem.x, problem.y, 0)
        repose.fit_given(problem.x, problem.y, kernel='ard-' + kernel, estimator='ml', basis='constant',
                         **{k: fitted[k] for k in ('length_scales', 'process_variance', 'noise_variance')})
        mean, sd, _ = repose.predict(points)
        their_mean, their_sd, _ = sklearn_predict(model, points[:2000])
        rows = []
        for _ in range(6):  # the first is thrown away
            row = {'load': load(), 'repose': repose.ask(op='predict')['seconds']}
            for side, block in (('whole', 100_000), ('blocks', 2000)):
                begin = time.perf_counter()
                for start in range(0, len(points), block):
                    model.predict(points[start:start + block], return_std=True)
                row[side] = time.perf_counter() - begin
            say(f'  {kernel}: {row}')
            rows.append(row)
        rows = rows[1:]
        results[kernel] = {'rows': rows, 'repose': median([r['repose'] for r in rows]),
                           'mean_difference': float(max(abs(mean[:2000] - their_mean)) / problem.function.sd),
                           'sd_difference': float(max(abs(sd[:2000] - their_sd)) / problem.function.sd)}
    return results


# ---- accuracy ----------------------------------------------------------------------------------

def score(problem, mean, function_sd, observation_sd):
    error, sd = problem.test_y - mean, np.maximum(observation_sd, 1e-12 * problem.function.sd)
    return {'rmse': float(np.sqrt(np.mean((problem.truth - mean) ** 2)) / problem.function.sd),
            'nlpd': float(np.mean(.5 * (error / sd) ** 2 + np.log(sd / problem.function.sd)) + .5 * math.log(2 * math.pi)),
            'coverage': float(np.mean(abs(error) <= 1.959964 * sd)),
            'function_coverage': float(np.mean(abs(problem.truth - mean) <= 1.959964 * function_sd))}


def repose_side(repose, problem, **options):
    fit = repose.fit(problem.x, problem.y, **options)
    mean, sd, observation_sd = repose.predict(problem.test_x)
    return {'seconds': fit['seconds'], 'noise': fit['noise_variance'] / problem.function.sd ** 2,
            'model': f"{fit['kernel']}, {fit['basis']}", **score(problem, mean, sd, observation_sd)}


def sklearn_side(problem, seed):
    model, fitted = sklearn_fit('matern52', problem.x, problem.y, 5, seed=seed)
    return {'seconds': fitted['seconds'], 'noise': fitted['noise_variance'] / problem.function.sd ** 2,
            **score(problem, *sklearn_predict(model, problem.test_x))}


def openturns_side(problem):
    result, fitted = openturns_fit(problem.x, problem.y, problem.noisy, 6)
    return {'seconds': fitted['seconds'], 'noise': fitted['noise_variance'] / problem.function.sd ** 2,
            **score(problem, *openturns_predict(result, fitted, problem.test_x))}


SIDES = {'repose': lambda repose, problem, _: repose_side(repose, problem),
         'repose, selected': lambda repose, problem, _: repose_side(repose, problem, select=True),
         'scikit-learn': lambda _, problem, seed: limited(lambda: sklearn_side(problem, seed)),
         'OpenTURNS': lambda _, problem, seed: limited(lambda: openturns_side(problem))}


def measure_side(repose, stage, side, functions):
    """Every function, with and without noise, 20 designs; failures are results."""
    file = f"{stage}_{side.replace(', ', '_')}"
    results = stored(file)
    program = hashlib.sha1(pathlib.Path(repose.program).read_bytes()).hexdigest()
    if side.startswith('repose') and results.get('program') != program:
        results = {}
    results['program'] = program
    for function in functions:
        for noise in ('exact', 'noisy'):
            for seed in range(1, DESIGNS + 1):
                key = f'{function.name}|{noise}|{seed}|{side}'
                if key in results:
                    continue
                results.setdefault('made', provenance())  # of the first fit
                try:
                    results[key] = SIDES[side](repose, Problem(function, noise == 'noisy', seed), seed)
                except Failure as failure:
                    results[key] = {'failure': str(failure)}
                    say(f'  {key}: {failure}')
                store(file, results)
        say(f'  {side}: {function.name}')


def accuracy_of(functions, stage):
    def run(repose, arguments):
        for side in arguments.sides or SIDES:
            measure_side(repose, stage, side, functions)
    return run


def stored_sides(stage):
    merged, made = {}, {}
    for side in SIDES:
        results = stored(f"{stage}_{side.replace(', ', '_')}")
        if 'made' in results:
            made[side] = results['made']
        merged.update(results)
    return {**merged, 'made': made}


STAGES = {'references': references, 'likelihoods': likelihoods, 'fit185': fit185, 'fit200': fit200, 'fit1000': fit1000,
          'predict': predict, 'accuracy': accuracy_of(ACCURACY, 'accuracy'),
          'held_out': accuracy_of(HELD_OUT, 'held_out')}
ALWAYS = {'references', 'likelihoods'}  # seconds
RESUMES = {'accuracy', 'held_out'}  # keep track of single fits themselves


class Sides(Repose):
    def fit_given(self, x, y, **options):
        d = x.shape[1]
        return self.ask(op='given', x=x.tolist(), y=y.tolist(), lower=[0.0] * d, upper=[1.0] * d, **options)


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument('stages', nargs='*', metavar='STAGE', help=f"what to measure anew: {', '.join(STAGES)}")
    parser.add_argument('--program', required=True, help='repose_gaussian_process_peers')
    parser.add_argument('--sides', action='append', help='of the accuracy stages: only this side (may be repeated)')
    parser.add_argument('-o', '--output', type=pathlib.Path)
    arguments = parser.parse_args()
    unknown = set(arguments.stages) - set(STAGES)
    if unknown:
        parser.error(f"no stage {', '.join(sorted(unknown))}; these are: {', '.join(STAGES)}")
    repose = Sides(arguments.program)
    for name, run in STAGES.items():
        named = name in arguments.stages
        complete = stored(name).get('result') is not None if name not in RESUMES else False
        if arguments.stages and not named and (complete or arguments.output is None or name in RESUMES):
            continue
        if not named and name not in ALWAYS and complete:
            continue
        say(f'{name}: {(run.__doc__ or "RMSE, density and coverage").strip().splitlines()[0]}')
        made = provenance()
        result = run(repose, arguments)
        if name not in RESUMES:
            store(name, {'result': result, 'made': made})
    if arguments.output:
        arguments.output.write_text(page.write({name: stored_sides(name) if name in RESUMES else stored(name) for name in STAGES}, arguments.program))
        say(f'{arguments.output} written')


if __name__ == '__main__':
    main()
