// The parameters of a study: names, ranges and scales, fixed values and ties between them.
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <map>
#include <string>
#include <vector>

namespace repose {

using Vector = Eigen::VectorXd;
/// Rows are points, columns are dimensions.
using Matrix = Eigen::MatrixXd;

class TomlTable;

enum class Scale { linear, log };

/// A parameter that may vary in [lower, upper].
struct Parameter {
  std::string name;
  double lower = 0.0;
  double upper = 1.0;
  Scale scale = Scale::linear;
  std::string unit = "1";
};

/// Reads NAME = { lower, upper, scale = "linear" | "log", unit }. Throws InputError with file and
/// line.
Parameter read_parameter(const TomlTable& parameters, const std::string& name);

/// A parameter whose value is the mean of others: one source makes them equal, the thesis' rule
/// mu_s_ps = (mu_s_pp + mu_s_ss)/2 has two.
struct Tie {
  std::string name;
  std::vector<std::string> sources;
};

/// Values by name, as a simulation wants them.
using ParameterValues = std::map<std::string, double>;

/// An ordered set of free parameters together with fixed and tied ones. Valid from construction:
/// names are unique, ranges are finite with lower < upper (and lower > 0 on a log scale), ties have
/// no cycles.
class ParameterSpace {
 public:
  ParameterSpace() = default;
  /// Throws InputError naming the parameter, its value and what is allowed.
  explicit ParameterSpace(std::vector<Parameter> free, ParameterValues fixed = {},
                          std::vector<Tie> ties = {});

  std::size_t dimension() const { return free_.size(); }
  const std::vector<Parameter>& parameters() const { return free_; }
  const ParameterValues& fixed() const { return fixed_; }
  const std::vector<Tie>& ties() const { return ties_; }
  std::vector<std::string> names() const;

  /// Between the unit cube and natural units, honouring log scales; vectors of length dimension().
  Vector from_unit(const Vector& unit) const;
  Vector to_unit(const Vector& natural) const;
  /// The same for many points, one a row.
  Matrix from_unit_rows(const Matrix& unit) const;

  /// Every value that a simulation needs: free ones as given, fixed ones, tied ones computed.
  ParameterValues complete(const Vector& natural) const;

 private:
  std::vector<Parameter> free_;
  ParameterValues fixed_;
  std::vector<Tie> ties_;  // in an order in which they can be computed
};

}  // namespace repose
