// Analysis of variance: the rotated response in an order of columns that puts a term behind those
// it is adjusted for.
#include "repose/doe/anova.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <limits>

#include "repose/base/error.hpp"
#include "repose/doe/distributions.hpp"
#include "scaled_qr.hpp"

namespace repose::doe {
namespace {

bool contains(const std::vector<int>& list, int value) {
  return std::find(list.begin(), list.end(), value) != list.end();
}

void check_input(const Matrix& x, const Vector& y, const std::vector<ColumnGroup>& groups) {
  if (x.rows() != y.size() || x.rows() < x.cols() || x.cols() == 0)
    throw InputError(
        fmt::format("analysis of variance: {} x {} model matrix for {} responses; at least as many "
                    "observations as columns are needed",
                    x.rows(), x.cols(), y.size()));
  if (!x.allFinite() || !y.allFinite())
    throw InputError("analysis of variance: a value of the model or the response is not finite");
  std::vector<int> taken;
  for (const ColumnGroup& group : groups) {
    if (group.columns.empty())
      throw InputError(fmt::format("analysis of variance: term {} has no columns", group.name));
    for (const int column : group.columns) {
      if (column < 0 || column >= x.cols() || contains(taken, column))
        throw InputError(fmt::format(
            "analysis of variance: term {} names column {}, which {}; columns are "
            "0 to {}",
            group.name, column, contains(taken, column) ? "is named twice" : "does not exist",
            x.cols() - 1));
      taken.push_back(column);
    }
    for (const int other : group.contained_in)
      if (other < 0 || other >= static_cast<int>(groups.size()))
        throw InputError(fmt::format(
            "analysis of variance: term {} is contained in term number {}; there are {} terms",
            group.name, other, groups.size()));
  }
}

std::vector<int> columns_outside(const std::vector<ColumnGroup>& groups, Eigen::Index columns) {
  std::vector<int> outside;
  for (int column = 0; column < columns; ++column)
    if (std::none_of(groups.begin(), groups.end(),
                     [&](const ColumnGroup& group) { return contains(group.columns, column); }))
      outside.push_back(column);
  return outside;
}

/// Is group `other` in the model that group `tested` is added to?
bool stands_before(const std::vector<ColumnGroup>& groups, int other, int tested,
                   SumsOfSquares type) {
  if (other == tested) return false;
  switch (type) {
    case SumsOfSquares::type_one:
      return other < tested;
    case SumsOfSquares::type_two:
      return !contains(groups[static_cast<std::size_t>(tested)].contained_in, other);
    case SumsOfSquares::type_three:
      return true;
  }
  return true;
}

/// What the columns `tested` explain of y after the columns `before`.
double explained_ss(const Matrix& x, const Vector& y, const std::vector<int>& before,
                    const std::vector<int>& tested) {
  std::vector<int> order = before;
  order.insert(order.end(), tested.begin(), tested.end());
  const ScaledQr qr(x(Eigen::all, order), {});
  return qr.rotated(y)
      .segment(static_cast<Eigen::Index>(before.size()), static_cast<Eigen::Index>(tested.size()))
      .squaredNorm();
}

}  // namespace

std::vector<AnovaRow> analysis_of_variance(const Matrix& x, const Vector& y,
                                           const std::vector<ColumnGroup>& groups,
                                           SumsOfSquares type) {
  check_input(x, y, groups);
  std::vector<std::string> names(static_cast<std::size_t>(x.cols()));
  for (std::size_t j = 0; j < names.size(); ++j) names[j] = fmt::format("column {}", j + 1);
  for (const ColumnGroup& group : groups)
    for (const int column : group.columns) names[static_cast<std::size_t>(column)] = group.name;
  const double residual_ss = ScaledQr(x, names).rotated(y).tail(x.rows() - x.cols()).squaredNorm();
  const auto residual_df = static_cast<double>(x.rows() - x.cols());

  std::vector<AnovaRow> rows;
  const std::vector<int> outside = columns_outside(groups, x.cols());
  for (int tested = 0; tested < static_cast<int>(groups.size()); ++tested) {
    std::vector<int> before = outside;
    for (int other = 0; other < static_cast<int>(groups.size()); ++other)
      if (stands_before(groups, other, tested, type)) {
        const auto& columns = groups[static_cast<std::size_t>(other)].columns;
        before.insert(before.end(), columns.begin(), columns.end());
      }
    const ColumnGroup& group = groups[static_cast<std::size_t>(tested)];
    AnovaRow row{.term = group.name,
                 .sum_of_squares = explained_ss(x, y, before, group.columns),
                 .df = static_cast<int>(group.columns.size()),
                 .f = std::numeric_limits<double>::quiet_NaN(),
                 .p = std::numeric_limits<double>::quiet_NaN()};
    if (residual_df > 0.0) {
      row.f = row.sum_of_squares / row.df / (residual_ss / residual_df);
      row.p = f_upper_tail(row.f, row.df, residual_df);
    }
    rows.push_back(std::move(row));
  }
  return rows;
}

std::vector<AnovaRow> analysis_of_variance(const Matrix& coded, const Vector& y,
                                           const std::vector<std::string>& factors,
                                           const std::vector<Term>& terms, SumsOfSquares type,
                                           const std::vector<int>& blocks) {
  std::vector<ColumnGroup> groups;
  for (std::size_t j = 0; j < terms.size(); ++j) {
    ColumnGroup group{.name = term_name(terms[j], factors), .columns = {static_cast<int>(j) + 1}};
    for (std::size_t other = 0; other < terms.size(); ++other) {
      const std::vector<Term> parts = precedents(terms[other]);
      if (std::find(parts.begin(), parts.end(), terms[j]) != parts.end())
        group.contained_in.push_back(static_cast<int>(other));
    }
    groups.push_back(std::move(group));
  }
  return analysis_of_variance(model_matrix(coded, terms, blocks), y, groups, type);
}

}  // namespace repose::doe
