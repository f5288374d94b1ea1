#include "repose/dem_adapter/segregation.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "repose/base/error.hpp"

namespace repose::dem_adapter {
namespace {

void need_two_bins(Eigen::Index bins) {
  if (bins < 2)
    throw InputError(fmt::format(
        "segregation needs at least 2 bins that hold something, there is {}; give a smaller size",
        bins));
}

/// Sum of the squared distances from `center`, and from the mean.
double squares(const Eigen::VectorXd& values, double center) {
  return (values.array() - center).square().sum();
}

/// Of the centre of mass of each component, m.
std::map<std::string, double> heights_of(const Mixture& mixture) {
  std::map<std::string, double> mass, height;
  for (std::size_t i = 0; i < mixture.size(); ++i) {
    const auto& name = mixture.components[static_cast<std::size_t>(mixture.component[i])];
    mass[name] += mixture.mass_kg[i];
    height[name] += mixture.mass_kg[i] * mixture.position[i].z();
  }
  for (auto& [name, moment] : height) moment /= mass[name];
  return height;
}

/// What each of these times stands for: half of what lies between its neighbours among all times.
Eigen::VectorXd durations(const std::vector<double>& time_s, const std::vector<std::size_t>& rows) {
  Eigen::VectorXd duration = Eigen::VectorXd::Ones(static_cast<Eigen::Index>(rows.size()));
  const std::size_t last = time_s.size() - 1;
  if (last == 0) return duration;
  for (std::size_t r = 0; r < rows.size(); ++r) {
    const std::size_t i = rows[r];
    const double before = i > 0 ? time_s[i] - time_s[i - 1] : time_s[1] - time_s[0];
    const double after = i < last ? time_s[i + 1] - time_s[i] : before;
    duration[static_cast<Eigen::Index>(r)] = 0.5 * (before + after);
  }
  return duration;
}

}  // namespace

Eigen::MatrixXd concentrations(const Eigen::MatrixXd& amounts) {
  return amounts.array().colwise() / amounts.rowwise().sum().array();
}

Bins filled(const Bins& bins, double least_fill) {
  const double least = least_fill * bins.mass_kg.sum() / static_cast<double>(bins.mass_kg.rows());
  Bins kept = bins;
  Eigen::Index rows = 0;
  for (Eigen::Index r = 0; r < bins.mass_kg.rows(); ++r) {
    if (bins.mass_kg.row(r).sum() < least) continue;
    kept.cell[static_cast<std::size_t>(rows)] = bins.cell[static_cast<std::size_t>(r)];
    kept.number.row(rows) = bins.number.row(r);
    kept.mass_kg.row(rows) = bins.mass_kg.row(r);
    kept.volume_m3.row(rows) = bins.volume_m3.row(r);
    ++rows;
  }
  kept.cell.resize(static_cast<std::size_t>(rows));
  for (Eigen::MatrixXd* amounts : {&kept.number, &kept.mass_kg, &kept.volume_m3})
    amounts->conservativeResize(rows, Eigen::NoChange);
  return kept;
}

std::vector<RelativeDeviation> relative_deviations(const Eigen::MatrixXd& amounts) {
  need_two_bins(amounts.rows());
  const Eigen::MatrixXd share = concentrations(amounts);
  std::vector<RelativeDeviation> result;
  for (Eigen::Index k = 0; k < share.cols(); ++k) {
    const double mean = share.col(k).mean();
    result.push_back({.mean = mean,
                      .deviation = std::sqrt(squares(share.col(k), mean) /
                                             static_cast<double>(share.rows() - 1))});
  }
  return result;
}

double random_deviation(const Mixture& mixture, int component, Basis basis,
                        const Eigen::MatrixXd& counts) {
  const auto amount = [&](std::size_t i) {
    return basis == Basis::number ? 1.0
           : basis == Basis::mass ? mixture.mass_kg[i]
                                  : mixture.volume_m3[i];
  };
  const auto n = static_cast<double>(mixture.size());
  double all = 0.0, tracer = 0.0, spread = 0.0;
  for (std::size_t i = 0; i < mixture.size(); ++i) {
    all += amount(i);
    if (mixture.component[i] == component) tracer += amount(i);
  }
  const double share = tracer / all;
  for (std::size_t i = 0; i < mixture.size(); ++i)
    spread += std::pow(amount(i) * ((mixture.component[i] == component ? 1.0 : 0.0) - share), 2);
  const double inverse_count = counts.rowwise().sum().array().inverse().mean();
  return std::sqrt(inverse_count * (spread / n) / std::pow(all / n, 2) * n / (n - 1.0));
}

Eigen::MatrixXd normalised_ratios(const Eigen::MatrixXd& amounts) {
  const Eigen::RowVectorXd share = amounts.colwise().sum() / amounts.sum();
  return concentrations(amounts).array().rowwise() / share.array();
}

SegregationIndices segregation_indices(const Bins& bins, int tracer) {
  need_two_bins(bins.number.rows());
  if (bins.components.size() < 2)
    throw InputError("there is one component only; segregation needs two");
  const auto m = static_cast<double>(bins.number.rows());
  const auto of_tracer = [&](const Eigen::MatrixXd& amounts) -> Eigen::VectorXd {
    return concentrations(amounts).col(tracer);
  };
  const auto in_all = [&](const Eigen::MatrixXd& amounts) {
    return amounts.col(tracer).sum() / amounts.sum();
  };
  const Eigen::VectorXd c = of_tracer(bins.volume_m3), y = of_tracer(bins.number);
  const Eigen::VectorXd x = of_tracer(bins.mass_kg) / in_all(bins.mass_kg);
  const Eigen::VectorXd grains = bins.number.rowwise().sum();
  const double y_all = in_all(bins.number), random_part = m / grains.sum();
  if (random_part >= 1.0)
    throw InputError(
        "the bins hold one grain each: every mixture looks segregated; give larger bins");
  const double s0 = y_all * (1.0 - y_all), sr = s0 * random_part;
  const double s = squares(y, y_all) / (m - 1.0);
  SegregationIndices index;
  index.panda_tan = std::sqrt(squares(c, in_all(bins.volume_m3)) / m);
  index.li = (grains.array() * (y.array() - y_all).square()).sum() / grains.sum() / s0;
  index.mantravadi_tan = std::sqrt(squares(x, x.mean()) / (m - 1.0));
  index.ketterhagen = std::sqrt(squares(x, x.mean()) / m);
  index.variance_fraction = (s - sr) / (s0 - sr);
  index.lacey = 1.0 - index.variance_fraction;
  // With m - 1 the variance of pure bins is above s_0.
  index.ashton_valentin = std::sqrt(std::max(std::log(s0 / s) / std::log(s0 / sr), 0.0));
  return index;
}

std::map<std::string, double> center_of_mass_shifts(const Mixture& initial, const Mixture& final) {
  const auto is_lower = [](const scene::Vec3& a, const scene::Vec3& b) { return a.z() < b.z(); };
  const auto [lowest, highest] =
      std::minmax_element(initial.position.begin(), initial.position.end(), is_lower);
  const double depth = initial.size() > 0 ? highest->z() - lowest->z() : 0.0;
  if (!(depth > 0.0))
    throw InputError(fmt::format(
        "the depth of the initial bed is {} m; the rise of a centre of mass needs one above 0",
        depth));
  const auto before = heights_of(initial), after = heights_of(final);
  std::map<std::string, double> shifts;
  for (const auto& [name, height] : before)
    if (const auto now = after.find(name); now != after.end())
      shifts[name] = (now->second - height) / depth;
  return shifts;
}

SegregationOverTime segregation_over_time(const Composition& composition,
                                          const Eigen::VectorXd& initial_share,
                                          const OverTimeOptions& options) {
  for (const double share : initial_share)
    if (!(share > 0.0 && share < 1.0))
      throw InputError(fmt::format(
          "the initial share of a component is {}; it must lie between 0 and 1", share));
  const Eigen::VectorXd total = composition.mass_kg.rowwise().sum();
  const double full = total.size() > 0 ? total.maxCoeff() : 0.0;
  SegregationOverTime result;
  for (Eigen::Index i = 0; i < total.size(); ++i)
    if (total[i] > 0.0 && total[i] > options.least_share * full)
      result.used.push_back(static_cast<std::size_t>(i));
  if (result.used.empty())
    throw InputError(fmt::format(
        "the sampling space never holds more than {:.3g} of {:.4g} kg; nothing passed through it",
        options.least_share, full));
  const auto rows = static_cast<Eigen::Index>(result.used.size());
  Eigen::MatrixXd mass(rows, composition.mass_kg.cols());
  for (Eigen::Index r = 0; r < rows; ++r)
    mass.row(r) = composition.mass_kg.row(
        static_cast<Eigen::Index>(result.used[static_cast<std::size_t>(r)]));
  const Eigen::ArrayXXd chi = concentrations(mass).array();
  const Eigen::ArrayXXd chi0 = initial_share.transpose().replicate(rows, 1).array();
  result.index = (chi - chi0).abs() / (1.0 - chi0);
  result.normalised_ratio = chi / chi0;
  const Eigen::VectorXd duration = durations(composition.time_s, result.used);
  result.mean_index = result.index.transpose() * duration / duration.sum();
  const double first = composition.time_s[result.used.front()];
  const double span = composition.time_s[result.used.back()] - first;
  for (const std::size_t row : result.used)
    result.normalised_time.push_back(span > 0.0 ? (composition.time_s[row] - first) / span : 0.0);
  return result;
}

}  // namespace repose::dem_adapter
