// Indices of segregation: pure functions of what lies in bins, or of a composition over time.
#pragma once

#include <Eigen/Core>
#include <map>
#include <span>
#include <string>
#include <vector>

#include "repose/dem_adapter/mixture.hpp"

namespace repose::dem_adapter {

/// Shares of the components in each bin: amounts (bins x components, >= 0, rows not all zero)
/// divided by their row sums.
Eigen::MatrixXd concentrations(const Eigen::MatrixXd& amounts);

/// Without the bins that hold less mass than `least_fill` times the mean of all bins: at the rim of
/// a heap bins hold few grains, whose concentration is chance. 0 keeps all, as the thesis does.
Bins filled(const Bins& bins, double least_fill);

/// The relative standard deviation of a component's concentrations over bins; every bin counts
/// alike [Hadi2026, Eq. 3.4, 5.2].
struct RelativeDeviation {
  double mean = 0.0;       ///< of the concentrations, not the component's share of everything
  double deviation = 0.0;  ///< with n - 1; to be compared where mixtures differ in composition
  double rsd() const { return deviation / mean; }
};

/// One a component. Throws InputError for fewer than two bins. Limits: 0 if all bins are alike;
/// sqrt(m / (m - 1) (1 - p) / p) if m bins are pure and a share p of them holds the component.
std::vector<RelativeDeviation> relative_deviations(const Eigen::MatrixXd& amounts);

/// The deviation that chance alone gives: expected (root mean square) deviation of the
/// concentrations of component k if the same grains lay in the bins in random order. With N_j
/// grains in bin j, N in all, amounts a_i, share p and t_i = 1 for grains of the component,
///   sigma^2 = mean_j(1 / N_j) mean_i(a_i^2 (t_i - p)^2) / mean_i(a_i)^2 N / (N - 1).
/// Exact for Basis::number and equal N_j; to first order in 1 / N_j otherwise. `counts` are
/// grains, bins x components.
double random_deviation(const Mixture& mixture, int component, Basis basis,
                        const Eigen::MatrixXd& counts);

/// chi_i(k) / chi_i^0: concentration of each component in each bin over its share in all bins
/// [Hadi2026, Eq. 6.1]; bins x components, 1 is perfectly mixed, NaN for one that is in no bin.
Eigen::MatrixXd normalised_ratios(const Eigen::MatrixXd& amounts);

/// Indices of [Hadi2026, Table 2.2] for one tracer; the concentrations of the tracer in m bins are
/// volume (c), number (y) or mass (x) shares.
struct SegregationIndices {
  double panda_tan = 0.0;          ///< No. 1: sqrt(sum (c^j - c)^2 / m); 0 is mixed
  double li = 0.0;                 ///< No. 2: sum N^j / N (y^j - y)^2 / (y (1 - y)); 0 to 1
  double mantravadi_tan = 0.0;     ///< No. 3: deviation of x^j / x, with m - 1; 0 is mixed
  double variance_fraction = 0.0;  ///< No. 4: (s^2 - s_r^2) / (s_0^2 - s_r^2); 0 to 1
  double ketterhagen = 0.0;        ///< No. 5: deviation of x^j / x, with m; 0 is mixed
  double ashton_valentin = 0.0;  ///< No. 7: sqrt(ln(s_0^2 / s^2) / ln(s_0^2 / s_r^2)); 1 is mixed,
                                 ///< 0 where s is above s_0, infinite if all bins are alike
  double lacey = 0.0;            ///< (s_0^2 - s^2) / (s_0^2 - s_r^2) = 1 - No. 4; 1 is mixed
};

/// s^2 = sum (y^j - y)^2 / (m - 1), s_0^2 = y (1 - y), s_r^2 = s_0^2 / n with n the mean number of
/// grains in a bin. Throws InputError for fewer than two bins, a single component, or bins of one
/// grain each, in which a random mixture cannot be told from a segregated one.
SegregationIndices segregation_indices(const Bins& bins, int tracer);

/// No. 9 of Table 2.2, of each component of both mixtures: how far its centre of mass rose between
/// two times, over the depth of the bed at first, from its lowest to its highest grain's centre. 0
/// is as before; of layers of half the bed each that change places, 1/2 and -1/2. Throws InputError
/// if the bed has no depth.
std::map<std::string, double> center_of_mass_shifts(const Mixture& initial, const Mixture& final);

/// The composition of what is in a sampling space over time.
struct Composition {
  std::vector<double> time_s;
  Eigen::MatrixXd mass_kg;  ///< times x components
};

struct OverTimeOptions {
  /// Times at which the sampling space holds no more than this share of the most that it ever holds
  /// are left out.
  double least_share = 0.02;
};

/// SI and NMR of a discharge.
struct SegregationOverTime {
  std::vector<std::size_t> used;  ///< rows of the composition
  /// (t - t_min) / (t_max - t_min) of the rows used [Hadi2026, Eq. 3.2]
  std::vector<double> normalised_time;
  Eigen::MatrixXd index;  ///< |chi - chi_0| / |1 - chi_0| [Eq. 3.1]; rows used x components
  Eigen::MatrixXd normalised_ratio;  ///< chi / chi_0 [Eq. 6.3]
  /// Over time, of the rows used: each counts for half of the time to its neighbours, the first and
  /// the last row of all for the time to their one. Where times are evenly spaced that is the plain
  /// mean of [Eq. 3.3].
  Eigen::VectorXd mean_index;
};

/// `initial_share` is chi_0 of each component, in (0, 1). Throws InputError if no time is left or a
/// share is not in that range.
SegregationOverTime segregation_over_time(const Composition& composition,
                                          const Eigen::VectorXd& initial_share,
                                          const OverTimeOptions& options = {});

}  // namespace repose::dem_adapter
