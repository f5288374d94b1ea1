// Terms of a second-order model in coded factors: main effects, two-factor interactions,
// quadratics.
#pragma once

#include <compare>
#include <string>
#include <vector>

#include "repose/base/parameter_space.hpp"

namespace repose::doe {

/// One column of a model matrix; factors are numbered from 0.
struct Term {
  enum class Kind { main_effect, interaction, quadratic };
  Kind kind = Kind::main_effect;
  int first = 0;
  int second = 0;  ///< > first for an interaction, else equal to it

  auto operator<=>(const Term&) const = default;
  bool contains(int factor) const { return factor == first || factor == second; }
};

Term main_effect(int factor);
/// Order of the two does not matter; equal factors are a quadratic.
Term interaction(int factor, int other);
Term quadratic(int factor);

/// The main effects that a term is made of; none for a main effect.
std::vector<Term> precedents(const Term& term);

enum class CandidateTerms { main_effects, main_and_second_order };

/// All main effects, then all interactions (0,1), (0,2), ..., then all quadratics.
std::vector<Term> candidate_terms(int factors, CandidateTerms which);

/// `mu_s`, `mu_s*mu_r`, `mu_s^2`.
std::string term_name(const Term& term, const std::vector<std::string>& factors);
/// "1" for the intercept, then the terms' names, then "block 2" ...: the columns of model_matrix().
std::vector<std::string> column_names(const std::vector<Term>& terms,
                                      const std::vector<std::string>& factors,
                                      const std::vector<int>& blocks = {});

/// A column of ones, then one column a term, then one for each block but the one with the lowest
/// number: 1 in its runs, else 0. `coded` is runs x factors, `blocks` numbers the block of each
/// run, empty for none. Throws InputError if a term names a factor that `coded` does not have, or
/// lengths differ.
Matrix model_matrix(const Matrix& coded, const std::vector<Term>& terms,
                    const std::vector<int>& blocks = {});

/// The column of one term.
Vector term_column(const Matrix& coded, const Term& term);

}  // namespace repose::doe
