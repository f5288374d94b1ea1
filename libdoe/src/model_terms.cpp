// Terms of second-order models and their columns.
#include "repose/doe/model_terms.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <set>

#include "repose/base/error.hpp"

namespace repose::doe {
namespace {

/// The numbers of the blocks in rising order, without the first.
std::vector<int> later_blocks(const std::vector<int>& blocks) {
  std::set<int> numbers(blocks.begin(), blocks.end());
  if (!numbers.empty()) numbers.erase(numbers.begin());
  return {numbers.begin(), numbers.end()};
}

}  // namespace

Term main_effect(int factor) {
  return {Term::Kind::main_effect, factor, factor};
}

Term quadratic(int factor) {
  return {Term::Kind::quadratic, factor, factor};
}

Term interaction(int factor, int other) {
  if (factor == other) return quadratic(factor);
  return {Term::Kind::interaction, std::min(factor, other), std::max(factor, other)};
}

std::vector<Term> precedents(const Term& term) {
  switch (term.kind) {
    case Term::Kind::main_effect:
      return {};
    case Term::Kind::interaction:
      return {main_effect(term.first), main_effect(term.second)};
    case Term::Kind::quadratic:
      return {main_effect(term.first)};
  }
  return {};
}

std::vector<Term> candidate_terms(int factors, CandidateTerms which) {
  std::vector<Term> terms;
  for (int i = 0; i < factors; ++i) terms.push_back(main_effect(i));
  if (which == CandidateTerms::main_effects) return terms;
  for (int i = 0; i < factors; ++i)
    for (int j = i + 1; j < factors; ++j) terms.push_back(interaction(i, j));
  for (int i = 0; i < factors; ++i) terms.push_back(quadratic(i));
  return terms;
}

std::string term_name(const Term& term, const std::vector<std::string>& factors) {
  const std::string& first = factors.at(static_cast<std::size_t>(term.first));
  switch (term.kind) {
    case Term::Kind::main_effect:
      return first;
    case Term::Kind::interaction:
      return first + "*" + factors.at(static_cast<std::size_t>(term.second));
    case Term::Kind::quadratic:
      return first + "^2";
  }
  return first;
}

std::vector<std::string> column_names(const std::vector<Term>& terms,
                                      const std::vector<std::string>& factors,
                                      const std::vector<int>& blocks) {
  std::vector<std::string> names{"1"};
  for (const Term& term : terms) names.push_back(term_name(term, factors));
  for (const int block : later_blocks(blocks)) names.push_back(fmt::format("block {}", block));
  return names;
}

Vector term_column(const Matrix& coded, const Term& term) {
  if (term.first < 0 || term.second < 0 || std::max(term.first, term.second) >= coded.cols())
    throw InputError(fmt::format("model term of factors {} and {}: the design has {} factors",
                                 term.first + 1, term.second + 1, coded.cols()));
  if (term.kind == Term::Kind::main_effect) return coded.col(term.first);
  return coded.col(term.first).cwiseProduct(coded.col(term.second));
}

Matrix model_matrix(const Matrix& coded, const std::vector<Term>& terms,
                    const std::vector<int>& blocks) {
  if (!blocks.empty() && static_cast<Eigen::Index>(blocks.size()) != coded.rows())
    throw InputError(fmt::format("model matrix: blocks of {} runs for a design of {} runs",
                                 blocks.size(), coded.rows()));
  const std::vector<int> later = later_blocks(blocks);
  Matrix x = Matrix::Zero(coded.rows(), 1 + static_cast<Eigen::Index>(terms.size() + later.size()));
  x.col(0).setOnes();
  Eigen::Index column = 1;
  for (const Term& term : terms) x.col(column++) = term_column(coded, term);
  for (const int block : later) {
    for (std::size_t run = 0; run < blocks.size(); ++run)
      if (blocks[run] == block) x(static_cast<Eigen::Index>(run), column) = 1.0;
    ++column;
  }
  return x;
}

}  // namespace repose::doe
