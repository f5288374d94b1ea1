// D-optimal designs by coordinate exchange.
#include "repose/doe/optimal_design.hpp"

#include <fmt/format.h>

#include <Eigen/Cholesky>
#include <Eigen/QR>
#include <algorithm>
#include <cmath>
#include <optional>

#include "repose/base/error.hpp"
#include "repose/base/random.hpp"

namespace repose::doe {
namespace {

constexpr double kSmallestGain = 1e-8;  // of the determinant; below it an exchange is rounding
constexpr int kMostTries = 10000;       // random runs until one is allowed

Vector model_row(const Vector& run, const std::vector<Term>& terms) {
  Vector row(1 + static_cast<Eigen::Index>(terms.size()));
  row[0] = 1.0;
  for (std::size_t t = 0; t < terms.size(); ++t)
    row[static_cast<Eigen::Index>(t) + 1] = terms[t].kind == Term::Kind::main_effect
                                                ? run[terms[t].first]
                                                : run[terms[t].first] * run[terms[t].second];
  return row;
}

std::vector<std::vector<double>> default_levels(int factors, const std::vector<Term>& terms) {
  std::vector<std::vector<double>> levels(static_cast<std::size_t>(factors), {-1.0, 1.0});
  for (const Term& term : terms)
    if (term.kind == Term::Kind::quadratic)
      levels[static_cast<std::size_t>(term.first)] = {-1.0, 0.0, 1.0};
  return levels;
}

void check_levels(const std::vector<std::vector<double>>& levels, int factors) {
  if (static_cast<int>(levels.size()) != factors)
    throw InputError(fmt::format("D-optimal design: levels of {} factors for {} factors",
                                 levels.size(), factors));
  for (std::size_t j = 0; j < levels.size(); ++j) {
    const auto& l = levels[j];
    const bool ascend = std::adjacent_find(l.begin(), l.end(),
                                           [](double a, double b) { return !(a < b); }) == l.end();
    if (l.size() < 2 || !ascend || !(l.front() >= -1.0) || !(l.back() <= 1.0))
      throw InputError(fmt::format(
          "D-optimal design: factor {} needs two or more levels that ascend in [-1, 1]", j + 1));
  }
}

void check_arguments(int factors, int runs, const std::vector<Term>& terms,
                     const OptimalDesignOptions& options) {
  if (factors < 1 || runs < 1 || options.starts < 1 || options.max_passes < 1)
    throw InputError(
        fmt::format("D-optimal design: {} factors, {} new runs, {} starts and {} passes; each must "
                    "be at least 1",
                    factors, runs, options.starts, options.max_passes));
  for (const Term& term : terms)
    if (term.first < 0 || std::max(term.first, term.second) >= factors)
      throw InputError(fmt::format("D-optimal design: a term of factors {} and {}, there are {}",
                                   term.first + 1, term.second + 1, factors));
  if (options.existing.rows() > 0 && options.existing.cols() != factors)
    throw InputError(fmt::format("D-optimal design: existing runs have {} factors instead of {}",
                                 options.existing.cols(), factors));
  const auto columns = terms.size() + 1;
  if (static_cast<std::size_t>(options.existing.rows() + runs) < columns)
    throw InputError(fmt::format(
        "D-optimal design: {} runs cannot estimate the {} coefficients of the model; make {} runs "
        "or choose a smaller model",
        options.existing.rows() + runs, columns, columns));
}

/// A design under exchange: its rows, their model rows and (X^T X)^-1.
class Exchange {
 public:
  Exchange(Matrix coded, Eigen::Index kept, const std::vector<Term>& terms,
           const std::vector<std::vector<double>>& levels, const RunFilter& allowed)
      : coded_(std::move(coded)),
        kept_(kept),
        terms_(terms),
        levels_(levels),
        allowed_(allowed),
        x_(model_matrix(coded_, terms)) {}

  /// False if X has not full rank.
  bool invert() {
    if (Eigen::ColPivHouseholderQR<Matrix>(x_).rank() < x_.cols()) return false;
    inverse_ = (x_.transpose() * x_).llt().solve(Matrix::Identity(x_.cols(), x_.cols()));
    return true;
  }
  /// Offers every coordinate of the new runs its best level; whether any changed.
  bool pass() {
    bool changed = false;
    for (Eigen::Index run = kept_; run < coded_.rows(); ++run)
      for (Eigen::Index factor = 0; factor < coded_.cols(); ++factor)
        changed = improve(run, factor) || changed;
    return changed;
  }
  const Matrix& coded() const { return coded_; }

 private:
  /// |X^T X| grows by this factor if a row x of X becomes y:
  /// (1 + y'Dy)(1 - x'Dx) + (x'Dy)^2, D = (X^T X)^-1 [Fedorov1972].
  static double gain(double variance_x, double variance_y, double covariance) {
    return (1.0 + variance_y) * (1.0 - variance_x) + covariance * covariance;
  }
  bool improve(Eigen::Index run, Eigen::Index factor) {
    const Vector old = x_.row(run).transpose();
    const Vector d_old = inverse_ * old;
    const double variance_old = old.dot(d_old);
    Vector candidate = coded_.row(run).transpose();
    const double present = candidate[factor];
    double best_gain = 1.0 + kSmallestGain, best_level = present;
    for (const double level : levels_[static_cast<std::size_t>(factor)]) {
      if (level == present) continue;
      candidate[factor] = level;
      const Vector row = model_row(candidate, terms_);
      const double g = gain(variance_old, row.dot(inverse_ * row), row.dot(d_old));
      if (g <= best_gain || (allowed_ && !allowed_(candidate))) continue;
      best_gain = g;
      best_level = level;
    }
    if (best_level == present) return false;
    candidate[factor] = best_level;
    coded_(run, factor) = best_level;
    const Vector row = model_row(candidate, terms_);
    x_.row(run) = row.transpose();
    update(row, 1.0);
    update(old, -1.0);
    return true;
  }
  /// (M + sign v v')^-1 [ShermanMorrison1950].
  void update(const Vector& v, double sign) {
    const Vector dv = inverse_ * v;
    inverse_ -= sign / (1.0 + sign * v.dot(dv)) * dv * dv.transpose();
  }

  Matrix coded_;
  Eigen::Index kept_;
  const std::vector<Term>& terms_;
  const std::vector<std::vector<double>>& levels_;
  const RunFilter& allowed_;
  Matrix x_;
  Matrix inverse_;
};

Vector random_run(const std::vector<std::vector<double>>& levels, const RunFilter& allowed,
                  RandomStream& random) {
  Vector run(static_cast<Eigen::Index>(levels.size()));
  for (int tried = 0; tried < kMostTries; ++tried) {
    for (std::size_t j = 0; j < levels.size(); ++j)
      run[static_cast<Eigen::Index>(j)] = levels[j][random.below(levels[j].size())];
    if (!allowed || allowed(run)) return run;
  }
  throw InputError(fmt::format(
      "D-optimal design: none of {} random runs obeys the constraints; give the factors "
      "more levels or loosen the constraints",
      kMostTries));
}

struct Start {
  Matrix coded;
  double d_efficiency = 0.0;
  int passes = 0;
};

/// One random start improved until nothing changes; none if the start has not full rank.
std::optional<Start> improved_start(int runs, const std::vector<Term>& terms,
                                    const std::vector<std::vector<double>>& levels,
                                    const OptimalDesignOptions& options, RandomStream& random) {
  const Eigen::Index kept = options.existing.rows();
  Matrix coded(kept + runs, static_cast<Eigen::Index>(levels.size()));
  if (kept > 0) coded.topRows(kept) = options.existing;
  for (Eigen::Index run = kept; run < coded.rows(); ++run)
    coded.row(run) = random_run(levels, options.allowed, random).transpose();
  Exchange exchange(std::move(coded), kept, terms, levels, options.allowed);
  int passes = 0;
  do {
    if (!exchange.invert()) return std::nullopt;  // anew in each pass: updates gather rounding
    ++passes;
  } while (exchange.pass() && passes < options.max_passes);
  return Start{exchange.coded(), d_efficiency(exchange.coded(), terms), passes};
}

}  // namespace

std::vector<Term> terms_of(ModelOrder order, int factors, const std::vector<int>& two_level) {
  std::vector<Term> terms;
  for (const Term& term : candidate_terms(factors, CandidateTerms::main_and_second_order)) {
    if (term.kind == Term::Kind::interaction && order == ModelOrder::linear) continue;
    const bool has_two_levels =
        std::find(two_level.begin(), two_level.end(), term.first) != two_level.end();
    if (term.kind == Term::Kind::quadratic && (order != ModelOrder::quadratic || has_two_levels))
      continue;
    terms.push_back(term);
  }
  return terms;
}

double d_efficiency(const Matrix& coded, const std::vector<Term>& terms) {
  const Matrix x = model_matrix(coded, terms);
  if (x.rows() < x.cols()) return 0.0;
  const Eigen::ColPivHouseholderQR<Matrix> qr(x);
  if (qr.rank() < x.cols()) return 0.0;
  const double log_root = qr.matrixR().diagonal().cwiseAbs().array().log().sum();
  return std::exp(2.0 * log_root / static_cast<double>(x.cols())) / static_cast<double>(x.rows());
}

OptimalDesign d_optimal_design(int factors, int runs, const std::vector<Term>& terms,
                               const OptimalDesignOptions& options) {
  check_arguments(factors, runs, terms, options);
  const auto levels = options.levels.empty() ? default_levels(factors, terms) : options.levels;
  check_levels(levels, factors);
  OptimalDesign best;
  constexpr int kMostSingular = 100;
  int singular = 0;
  RandomStream random(options.seed);
  while (static_cast<int>(best.efficiencies.size()) < options.starts) {
    auto start = improved_start(runs, terms, levels, options, random);
    if (!start) {
      if (++singular < kMostSingular * options.starts) continue;
      throw InputError(
          "D-optimal design: no random start can estimate every term of the model; give the "
          "factors "
          "more levels, make more runs, loosen the constraints or choose a smaller model");
    }
    best.efficiencies.push_back(start->d_efficiency);
    if (start->d_efficiency <= best.d_efficiency) continue;
    best.coded = std::move(start->coded);
    best.d_efficiency = start->d_efficiency;
    best.passes = start->passes;
  }
  return best;
}

}  // namespace repose::doe
