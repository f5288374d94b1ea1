// Linear models in files.
#include <cmath>
#include <limits>

#include "linear_state.hpp"
#include "model_kinds.hpp"

namespace repose::surrogate {
namespace {

constexpr std::array kMethods{LinearMethod::least_squares, LinearMethod::robust,
                              LinearMethod::stepwise};

/// The constant first, then a row a term; a main effect has its column twice.
table::Table terms_table(const LinearModelAccess::State& s) {
  std::vector<std::int64_t> first{-1}, second{-1};
  for (const doe::Term& term : s.terms) {
    first.push_back(term.first);
    second.push_back(term.second);
  }
  table::Table t;
  add_column(t, "first", first);
  add_column(t, "second", second);
  add_column(t, "coefficient", doubles(s.coefficients));
  return t;
}

table::Table matrix_table(const Matrix& m) {
  table::Table t;
  add_column(t, "values", doubles(m.reshaped()));
  return t;
}

void read_terms(const ModelReader& file, LinearModelAccess::State& s) {
  const table::Table t = file.read("/terms");
  const auto first = t.integers("first"), second = t.integers("second");
  file.check(first.size() >= 1 && first[0] == -1, "/terms does not begin with the constant");
  for (std::size_t i = 1; i < first.size(); ++i) {
    file.check(first[i] >= 0 && first[i] <= second[i] && second[i] < s.columns.count(),
               "/terms names a column that is not there");
    const int a = static_cast<int>(first[i]), b = static_cast<int>(second[i]);
    s.terms.push_back(a == b ? doe::main_effect(a) : doe::interaction(a, b));
  }
  s.coefficients = vector_of(t.numbers("coefficient"));
}

Matrix read_matrix(const ModelReader& file, const std::string& group, Eigen::Index rows,
                   Eigen::Index columns) {
  const std::vector<double> values = file.read(group).numbers("values");
  file.check(static_cast<Eigen::Index>(values.size()) == rows * columns,
             "a matrix has the wrong length");
  return Eigen::Map<const Matrix>(values.data(), rows, columns);
}

}  // namespace

std::optional<ModelContent> write_linear_model(const Regressor& model) {
  const auto* linear = model.target<LinearModel>();
  if (linear == nullptr) return std::nullopt;
  const auto& s = LinearModelAccess::state(*linear);
  ModelContent content{
      .attributes = {{"method", std::string(to_string(s.method))},
                     {"rank", static_cast<std::int64_t>(s.report.rank)},
                     {"residual_df", static_cast<std::int64_t>(s.report.residual_df)},
                     {"iterations", static_cast<std::int64_t>(s.report.iterations)},
                     {"converged", static_cast<std::int64_t>(s.report.converged ? 1 : 0)}}};
  if (std::isfinite(s.error_variance)) content.attributes["error_variance"] = s.error_variance;
  if (std::isfinite(s.coefficient_variance))
    content.attributes["coefficient_variance"] = s.coefficient_variance;
  content.add("/terms", terms_table(s));
  content.add("/root", matrix_table(s.root));
  content.add("/row_space", matrix_table(s.row_space));
  return content;
}

Regressor read_linear_model(const ModelReader& file, std::vector<Input> inputs) {
  constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
  LinearModelAccess::State s{.columns = CodedColumns(std::move(inputs))};
  s.method = file.choice(file.get<std::string>("method"), kMethods);
  read_terms(file, s);
  const Eigen::Index coefficients = s.coefficients.size();
  const Eigen::Index rank = file.get<std::int64_t>("rank");
  file.check(rank >= 1 && rank <= coefficients, "the rank is impossible");
  s.root = read_matrix(file, "/root", coefficients, rank);
  if (rank < coefficients) s.row_space = read_matrix(file, "/row_space", coefficients, rank);
  const auto variance = [&file](const char* name) {
    return file.has(name) ? file.positive_or_zero(name) : kNaN;
  };
  s.error_variance = variance("error_variance");
  s.coefficient_variance = variance("coefficient_variance");
  s.report = {.coefficients = coefficients,
              .rank = rank,
              .residual_df = file.get<std::int64_t>("residual_df"),
              .iterations = static_cast<int>(file.get<std::int64_t>("iterations")),
              .converged = file.get<std::int64_t>("converged") == 1};
  return LinearModelAccess::make(std::move(s));
}

}  // namespace repose::surrogate
