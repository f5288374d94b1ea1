// The parameters of a study: names, ranges and scales, levels, fixed values, ties between them and
// linear constraints on them.
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <limits>
#include <map>
#include <string>
#include <vector>

namespace repose {

using Vector = Eigen::VectorXd;
/// Rows are points, columns are dimensions.
using Matrix = Eigen::MatrixXd;

class TomlTable;

enum class Scale { linear, log };

/// Which values of its range a parameter takes: all, whole numbers, those of a list, or names.
enum class ParameterKind { continuous, integer, levels, categorical };

/// A parameter that may vary in [lower, upper].
struct Parameter {
  std::string name;
  double lower = 0.0;
  double upper = 1.0;
  Scale scale = Scale::linear;
  std::string unit = "1";
  ParameterKind kind = ParameterKind::continuous;
  /// The values of kind `levels`, ascending; `lower` and `upper` are the first and the last.
  std::vector<double> levels = {};
  /// The names of kind `categorical`; its values are their places 0, 1, ...
  std::vector<std::string> categories = {};
};

/// How many values a parameter can take; 0 for a continuous one.
std::size_t level_count(const Parameter& parameter);

/// Value at a place in [0, 1] (clamped). 0 gives `lower`, 1 `upper`; levels have equal shares of
/// the interval, whole numbers on a log scale shares in proportion to log((i + 1)/i).
double natural_value(const Parameter& parameter, double unit);
/// Place in [0, 1] with natural_value(unit_value(v)) = v up to rounding, exactly for whole numbers
/// and levels; a value that is no level is taken for the nearest.
double unit_value(const Parameter& parameter, double natural);

/// Reads NAME = { lower, upper, scale = "linear" | "log", unit, integer = true }, or
/// { levels = [0.1, 0.2], unit }, or { categories = ["layered", "mixed"] }. Throws InputError with
/// file and line.
Parameter read_parameter(const TomlTable& parameters, const std::string& name);

/// A parameter whose value is the mean of others: one source makes them equal, the thesis' rule
/// mu_s_ps = (mu_s_pp + mu_s_ss)/2 has two.
struct Tie {
  std::string name;
  std::vector<std::string> sources;
};

/// lower <= sum of coefficient x value <= upper, over free, fixed and tied parameters, in natural
/// units.
struct LinearConstraint {
  std::string name;
  std::map<std::string, double> coefficients;
  double lower = -std::numeric_limits<double>::infinity();
  double upper = std::numeric_limits<double>::infinity();
};

/// Values by name, as a simulation wants them.
using ParameterValues = std::map<std::string, double>;

/// An ordered set of free parameters together with fixed and tied ones. Valid from construction:
/// names are unique, ranges are finite with lower < upper (and lower > 0 on a log scale), lists
/// have two levels or more, ties have no cycles and constraints name parameters that are numbers.
class ParameterSpace {
 public:
  ParameterSpace() = default;
  /// Throws InputError naming the parameter, its value and what is allowed.
  explicit ParameterSpace(std::vector<Parameter> free, ParameterValues fixed = {},
                          std::vector<Tie> ties = {},
                          std::vector<LinearConstraint> constraints = {});

  std::size_t dimension() const { return free_.size(); }
  const std::vector<Parameter>& parameters() const { return free_; }
  const ParameterValues& fixed() const { return fixed_; }
  const std::vector<Tie>& ties() const { return ties_; }
  const std::vector<LinearConstraint>& constraints() const { return constraints_; }
  std::vector<std::string> names() const;

  /// Between the unit cube and natural units, honouring scales and levels; vectors of length
  /// dimension().
  Vector from_unit(const Vector& unit) const;
  Vector to_unit(const Vector& natural) const;
  /// The same for many points, one a row.
  Matrix from_unit_rows(const Matrix& unit) const;

  /// Every value that a simulation needs: free ones as given, fixed ones, tied ones computed.
  ParameterValues complete(const Vector& natural) const;

  /// Whether a point obeys all constraints, each up to 1e-9 of the size of its terms.
  bool obeys_constraints(const Vector& natural) const;
  /// One clause for each constraint that a point breaks: "share: 1 a + 1 b = 0.9 is above 0.8".
  std::vector<std::string> broken_constraints(const Vector& natural) const;

 private:
  std::vector<Parameter> free_;
  ParameterValues fixed_;
  std::vector<Tie> ties_;  // in an order in which they can be computed
  std::vector<LinearConstraint> constraints_;
};

/// Reads [parameters] and, if present, [fixed] (NAME = value), [ties] (NAME = ["source", ...]) and
/// [constraints] (NAME = { coefficients = { a = 1, b = -2 }, lower, upper }). Throws InputError
/// with file and line.
ParameterSpace read_parameter_space(const TomlTable& root);

}  // namespace repose
