// A screening as figures: half-normal plots and main effects.
#include <algorithm>
#include <cctype>
#include <cmath>
#include <numeric>
#include <set>

#include "repose/base/file.hpp"
#include "repose/doe/distributions.hpp"
#include "repose/plot/figure.hpp"
#include "screen_report.hpp"

namespace repose::cli {
namespace {

using doe::ResponseScreening;

constexpr std::size_t kMostNamed = 7;  // colours; the eighth is for all others

/// Factors by the size of their effect, the largest first.
std::vector<std::size_t> by_effect(const ResponseScreening& response) {
  std::vector<std::size_t> order(static_cast<std::size_t>(response.effect.size()));
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::stable_sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) {
    return std::abs(response.effect(static_cast<Eigen::Index>(a))) >
           std::abs(response.effect(static_cast<Eigen::Index>(b)));
  });
  return order;
}

/// Sorted absolute effects against the quantiles of noise: what matters lies above the line whose
/// slope is the standard error of an effect.
plot::Figure half_normal_plot(const ScreeningReport& report, const ResponseScreening& response) {
  plot::Figure figure("Half-normal plot: " + response.response, {.label = "Half-normal quantile"},
                      {.label = "|Effect|, coded units", .lower = 0.0});
  const auto order = by_effect(response);
  const Vector quantiles = doe::half_normal_quantiles(static_cast<int>(order.size()));
  std::vector<double> x, y;
  std::size_t named = 0;
  for (std::size_t rank = 0; rank < order.size(); ++rank) {
    const double quantile = quantiles(static_cast<Eigen::Index>(order.size() - 1 - rank));
    const double size = std::abs(response.effect(static_cast<Eigen::Index>(order[rank])));
    if (report.is_selected(response, order[rank]) && named < kMostNamed) {
      ++named;
      figure.scatter(std::span(&quantile, 1), std::span(&size, 1),
                     report.screening.factors[order[rank]]);
    } else {
      x.push_back(quantile);
      y.push_back(size);
    }
  }
  if (!x.empty()) figure.scatter(x, y, named == 0 ? "" : "other factors");
  const double error = response.pooled_standard_error.mean();
  if (std::isfinite(error)) {
    const double end = quantiles(quantiles.size() - 1);
    const std::vector<double> line_x{0.0, end}, line_y{0.0, error * end};
    figure.lines(line_x, line_y, "noise of the repetitions", plot::LineStyle::dashed);
  }
  return figure;
}

/// Mean of the response at each level of a factor; of the fitted line where there are too many.
void add_main_effect(plot::Figure& figure, const ScreeningReport& report, const Matrix& values,
                     const ResponseScreening& response, std::size_t factor, double mean) {
  constexpr std::size_t kMostLevels = 5;
  const auto k = static_cast<Eigen::Index>(factor);
  const Vector column = report.coded.col(k);
  const std::set<double> levels(column.begin(), column.end());
  std::vector<double> x, y;
  if (levels.size() > kMostLevels) {
    x = {-1.0, 1.0};
    y = {mean - response.effect(k), mean + response.effect(k)};
  } else {
    for (const double level : levels) {
      double sum = 0.0, count = 0.0;
      for (Eigen::Index run = 0; run < values.rows(); ++run)
        for (Eigen::Index r = 0; r < values.cols(); ++r)
          if (column(run) == level && !std::isnan(values(run, r))) {
            sum += values(run, r);
            count += 1.0;
          }
      if (count == 0.0) continue;
      x.push_back(level);
      y.push_back(sum / count);
    }
  }
  figure.lines(x, y, report.screening.factors[factor]);
  figure.scatter(x, y, report.screening.factors[factor]);
}

plot::Figure main_effects_plot(const ScreeningReport& report, const ResponseScreening& response,
                               const Matrix& values) {
  plot::Figure figure("Main effects: " + response.response,
                      {.label = "Level: low -1, middle 0, high 1", .lower = -1.1, .upper = 1.1},
                      {.label = "Mean of " + response.response});
  double sum = 0.0, count = 0.0;
  for (const double value : values.reshaped())
    if (!std::isnan(value)) {
      sum += value;
      count += 1.0;
    }
  auto order = by_effect(response);
  if (order.size() > kMostNamed) {
    order.resize(kMostNamed);
    figure.note("the " + std::to_string(kMostNamed) + " factors with the largest effects");
  }
  for (const std::size_t factor : order)
    add_main_effect(figure, report, values, response, factor, sum / count);
  figure.horizontal_line(sum / count, "mean");
  return figure;
}

/// A response as part of a file name that no other one has.
std::string file_name(const std::string& response, std::set<std::string>& taken) {
  std::string name = response;
  for (char& c : name)
    if (std::isalnum(static_cast<unsigned char>(c)) == 0 && c != '_' && c != '-') c = '_';
  std::string unique = name;
  for (int i = 2; !taken.insert(unique).second; ++i) unique = name + "_" + std::to_string(i);
  return unique;
}

}  // namespace

std::vector<std::filesystem::path> write_screening_plots(const ScreeningReport& report,
                                                         const std::filesystem::path& directory) {
  make_directory(directory);
  std::vector<std::filesystem::path> files;
  std::set<std::string> taken;
  for (std::size_t r = 0; r < report.screening.responses.size(); ++r) {
    const auto& response = report.screening.responses[r];
    const auto name = file_name(response.response, taken);
    const auto write = [&](const std::string& kind, const plot::Figure& figure) {
      files.push_back(directory / (kind + "_" + name + ".svg"));
      write_file_atomically(files.back(), figure.svg());
    };
    write("half_normal", half_normal_plot(report, response));
    write("main_effects", main_effects_plot(report, response, report.values[r]));
  }
  return files;
}

}  // namespace repose::cli
