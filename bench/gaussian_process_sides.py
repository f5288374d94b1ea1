"""repose, scikit-learn and OpenTURNS behind one interface, one thread each."""
import json
import math
import os
import pickle
import select
import signal
import subprocess
import time
import warnings

import numpy as np
import openturns as ot
import scipy.optimize
from sklearn.exceptions import ConvergenceWarning
from sklearn.gaussian_process import GaussianProcessRegressor
from sklearn.gaussian_process.kernels import RBF, ConstantKernel, Matern, WhiteKernel

from gaussian_process_problems import latin_hypercube, negative_log_likelihoods

LIMIT_S = 300
ot.Log.Show(ot.Log.NONE)
ot.TBB.Disable()
warnings.filterwarnings('ignore', category=ConvergenceWarning)


class Failure(Exception):
    """A fit that gave no model within its time."""


class Repose:
    """bench/gaussian_process_peers.cpp as a child process."""

    def __init__(self, program):
        self.program = program
        self.process = None

    def ask(self, **request):
        if self.process is None:
            self.process = subprocess.Popen([self.program], stdin=subprocess.PIPE, stdout=subprocess.PIPE)
        self.process.stdin.write(json.dumps(request).encode() + b'\n')
        self.process.stdin.flush()
        if not select.select([self.process.stdout], [], [], LIMIT_S)[0]:
            self.process.kill()
            self.process = None
            raise Failure(f'no answer within {LIMIT_S} s')
        line = self.process.stdout.readline()
        if not line:
            self.process = None
            raise Failure('the program ended')
        answer = json.loads(line)
        if 'error' in answer:
            raise Failure(answer['error'])
        return answer

    def fit(self, x, y, **options):
        d = x.shape[1]
        return self.ask(op='fit', x=x.tolist(), y=y.tolist(), lower=[0.0] * d, upper=[1.0] * d, **options)

    def predict(self, x):
        self.ask(op='points', x=x.tolist())
        answer = self.ask(op='predict', values=True)
        return tuple(np.array(answer[key]) for key in ('mean', 'sd', 'observation_sd'))


def limited(call):
    """call() in a forked copy of this process that is stopped after LIMIT_S."""
    read, write = os.pipe()
    child = os.fork()
    if child == 0:
        os.close(read)
        try:
            result = call()
        except Exception as error:  # a failure of the peer, which is counted
            result = Failure(f'{type(error).__name__}: {str(error)[:200]}')
        with os.fdopen(write, 'wb') as out:
            pickle.dump(result, out)
        os._exit(0)
    os.close(write)
    data, end = b'', time.monotonic() + LIMIT_S
    with os.fdopen(read, 'rb') as stream:
        while True:
            if not select.select([stream], [], [], max(0.0, end - time.monotonic()))[0]:
                os.kill(child, signal.SIGKILL)
                os.waitpid(child, 0)
                raise Failure(f'no model within {LIMIT_S} s')
            part = os.read(stream.fileno(), 1 << 20)
            if not part:
                break
            data += part
    os.waitpid(child, 0)
    result = pickle.loads(data) if data else Failure('the process died')
    if isinstance(result, Failure):
        raise result
    return result


# ---- scikit-learn ------------------------------------------------------------------------------

def sklearn_kernel(kernel, d, longest):
    scales, bounds = [1.0] * d, (1e-2, longest)
    shape = RBF(scales, bounds) if kernel == 'squared-exponential' else Matern(scales, bounds, nu=2.5)
    return ConstantKernel(1.0, (1e-3, 1e9)) * shape + WhiteKernel(1e-2, (1e-12, 1e1))


def sklearn_fit(kernel, x, y, restarts, seed=1, starts=None):
    """With `starts` (rows of log length scales and log noise ratio) it begins there and nowhere else, the amplitude's
    start being the best one, with the longest scale that repose allows; its own restarts are drawn over all of the range,
    which should not be that wide."""
    model = GaussianProcessRegressor(sklearn_kernel(kernel, x.shape[1], 1e3 if starts is None else 1e5), normalize_y=True,
                                     n_restarts_optimizer=restarts, random_state=seed)
    if starts is not None:
        standardised = (y - y.mean()) / y.std()
        thetas = [theta_at(kernel, x, standardised, np.array(s)) for s in starts]
        model.optimizer = lambda f, _, bounds: best_of(f, thetas, bounds)
    begin = time.perf_counter()
    model.fit(x, y)
    seconds = time.perf_counter() - begin
    k, unit = model.kernel_, float(np.var(y))
    return model, {'seconds': seconds, 'length_scales': np.atleast_1d(k.k1.k2.length_scale).tolist(),
                   'process_variance': k.k1.k1.constant_value * unit, 'noise_variance': k.k2.noise_level * unit}


def theta_at(kernel, x, y, start):
    """scikit-learn's parameters (log amplitude, log scales, log noise) at the best amplitude there."""
    scales, ratio = np.exp(start[:-1]), math.exp(start[-1])
    unit = negative_log_likelihoods(kernel, x, y, scales, 1.0, ratio)['of y']
    double = negative_log_likelihoods(kernel, x, y, scales, 2.0, 2.0 * ratio)['of y']
    n = len(y)  # the two differ by (n log 2)/2 - S/4, S = y' C^-1 y
    s = 4 * (.5 * n * math.log(2) - (double - unit))
    amplitude = max(s / n, 1e-3)
    return np.concatenate([[math.log(amplitude)], start[:-1], [math.log(amplitude * ratio)]])


def best_of(f, thetas, bounds):
    runs = [scipy.optimize.minimize(f, np.clip(t, bounds[:, 0], bounds[:, 1]), method='L-BFGS-B', jac=True, bounds=bounds)
            for t in thetas]
    best = min(runs, key=lambda r: r.fun)
    return best.x, best.fun


def sklearn_predict(model, x):
    """Mean, sd of the function and of an observation."""
    mean, observed = model.predict(x, return_std=True)
    noise = model.kernel_.k2.noise_level * model._y_train_std ** 2
    return mean, np.sqrt(np.maximum(observed ** 2 - noise, 0.0)), observed


# ---- OpenTURNS ---------------------------------------------------------------------------------

# 1.20 does not estimate a nugget (KrigingAlgorithm.setNoise takes known variances only), so the
# nugget, in units of the process variance, is searched for outside by the likelihood.
OT_NUGGETS = (1e-4, 1e-3, 1e-2, 1e-1)
OT_STEP = math.sqrt(10) ** .5


def openturns_starts(d, count):
    """Length scales around 0.632 sqrt(d) ranges, by factors of 1/3 to 3 in each input."""
    spread = 3.0 ** (2 * latin_hypercube(count, d, 5) - 1)
    spread[0] = 1.0
    return .632 * math.sqrt(d) * spread


def openturns_run(x, y, nugget, starts):
    d = x.shape[1]
    covariance = ot.MaternModel(list(starts[0]), [1.0], 2.5)
    covariance.setNuggetFactor(nugget)
    algorithm = ot.KrigingAlgorithm(ot.Sample(x), ot.Sample(y.reshape(-1, 1)), covariance, ot.ConstantBasisFactory(d).build())
    algorithm.setOptimizationBounds(ot.Interval([0.01] * d, [100.0] * d))
    algorithm.setOptimizationAlgorithm(ot.MultiStart(ot.TNC(), ot.Sample(starts)))
    algorithm.run()
    result = algorithm.getResult()
    p = np.array(result.getCovarianceModel().getParameter())
    scales, variance = p[:d], p[d] ** 2
    value = negative_log_likelihoods('matern52', x, y, scales, variance, nugget * variance)['profiled']
    return result, scales, variance, value


def try_nugget(tried, x, y, nugget, starts):
    try:
        tried[nugget] = openturns_run(x, y, nugget, starts)
    except RuntimeError:  # "None of the local searches succeeded": the other nuggets decide
        pass


def openturns_fit(x, y, noisy, count):
    """Of standardised y: the best nugget of a grid and beside it from one start each, then all starts."""
    shift, scale = y.mean(), y.std()
    y = (y - shift) / scale
    starts = openturns_starts(x.shape[1], count)
    begin = time.perf_counter()
    if not noisy:
        try:
            result, scales, variance, _ = openturns_run(x, y, 1e-12, starts)
            nugget = 1e-12
        except Exception:  # a matrix that cannot be factored: as its users do, more nugget
            nugget = 1e-8
            result, scales, variance, _ = openturns_run(x, y, nugget, starts)
    else:
        tried = {}
        for g in OT_NUGGETS:
            try_nugget(tried, x, y, g, starts[:1])
        if not tried:
            raise Failure('no nugget gave a model')
        nugget = min(tried, key=lambda g: tried[g][3])
        for g in (nugget / OT_STEP, nugget * OT_STEP):
            try_nugget(tried, x, y, g, [tried[nugget][1]])
        nugget = min(tried, key=lambda g: tried[g][3])
        result, scales, variance, _ = openturns_run(x, y, nugget, np.vstack([starts, tried[nugget][1]]))
    seconds = time.perf_counter() - begin
    return result, {'seconds': seconds, 'shift': shift, 'scale': scale, 'nugget': nugget,
                    'length_scales': scales.tolist(), 'process_variance': variance * scale ** 2,
                    'noise_variance': nugget * variance * scale ** 2}


def openturns_predict(result, fitted, x):
    """Its variance holds the nugget wherever x is no training point."""
    mean = fitted['shift'] + fitted['scale'] * np.array(result.getConditionalMean(ot.Sample(x))).ravel()
    observed = np.array(result.getConditionalMarginalVariance(ot.Sample(x))).ravel() * fitted['scale'] ** 2
    noise = fitted['noise_variance']
    return mean, np.sqrt(np.maximum(observed - noise, 0.0)), np.sqrt(np.maximum(observed, 0.0))
