// A table like that of [Hadi2026, chapter 4]: a definitive screening design of 15 factors in 37
// runs, done once for each of five initial configurations, with a known response. Shared by tests
// and bench.
#pragma once

#include <array>
#include <string>
#include <vector>

#include "repose/base/random.hpp"
#include "repose/doe/designs.hpp"
#include "repose/surrogate/training_set.hpp"

namespace repose::surrogate::test {

struct GroupedScreening {
  TrainingSet data;                ///< 185 rows x 18 inputs; groups 0 to 4
  std::vector<std::string> names;  ///< of the inputs
  Vector expected;                 ///< the response without noise
};

/// Segregation index, mass ratio of pellets, layering mode: [Hadi2026, Table 4.1].
inline constexpr std::array<std::array<double, 3>, 5> kConfigurations{
    {{1.0, 0.5, 1.0}, {1.0, 0.5, 2.0}, {0.0, 0.5, 3.0}, {1.0, 0.75, 1.0}, {1.0, 0.25, 1.0}}};

/// x: 15 coded factors and the three numbers of a configuration. Six factors matter, two of them
/// together, one by its square; the configuration shifts the response and changes two slopes.
template <class RowLike>
double grouped_response(const RowLike& x) {
  const double ratio = (x[16] - 0.5) / 0.25;
  const double mode = x[17] - 2.0;
  const double shift = 0.5 + 0.06 * x[15] + 0.08 * ratio - 0.04 * mode;
  return shift + (0.10 + 0.03 * ratio) * x[0] + (0.07 - 0.02 * mode) * x[1] - 0.05 * x[2] +
         0.04 * x[3] + 0.05 * x[0] * x[1] + 0.04 * x[4] * x[4] - 0.03 * x[2] * x[5];
}

/// The same design in each configuration, with independent normal noise.
inline GroupedScreening grouped_screening(std::uint64_t seed, double noise = 0.01) {
  doe::DefinitiveScreeningOptions options;
  options.run_order = doe::RunOrder::structured;
  const Matrix design = doe::definitive_screening_design(15, options).coded;
  const Eigen::Index runs = design.rows();
  GroupedScreening result;
  TrainingSet& data = result.data;
  data.x.resize(5 * runs, 18);
  data.y.resize(5 * runs);
  result.expected.resize(5 * runs);
  RandomStream random(seed);
  for (Eigen::Index i = 0; i < data.x.rows(); ++i) {
    const Eigen::Index group = i / runs;
    data.x.row(i).head(15) = design.row(i % runs);
    for (Eigen::Index k = 0; k < 3; ++k)
      data.x(i, 15 + k) =
          kConfigurations[static_cast<std::size_t>(group)][static_cast<std::size_t>(k)];
    result.expected[i] = grouped_response(data.x.row(i));
    data.y[i] = result.expected[i] + noise * random.normal();
    data.groups.push_back(group);
  }
  for (int k = 1; k <= 15; ++k) {
    data.inputs.push_back({.lower = -1.0, .upper = 1.0});
    result.names.push_back("x" + std::to_string(k));
  }
  data.inputs.push_back({.lower = 0.0, .upper = 1.0});
  data.inputs.push_back({.lower = 0.25, .upper = 0.75});
  data.inputs.push_back({.lower = 1.0, .upper = 3.0});
  for (const char* name : {"segregation_index", "pellet_mass_ratio", "layering_mode"})
    result.names.emplace_back(name);
  return result;
}

}  // namespace repose::surrogate::test
