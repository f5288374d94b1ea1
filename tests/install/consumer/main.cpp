// A design is made, measured, written, read back, modelled and its minimum found, each step
// checked.
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <filesystem>

#include "repose/doe/designs.hpp"
#include "repose/doe/space_filling.hpp"
#include "repose/opt/minimizer.hpp"
#include "repose/surrogate/gaussian_process.hpp"
#include "repose/table/io.hpp"

bool is_safe_with_other_alignment();  // other_alignment.cpp

namespace {

void require(bool condition, const char* what) {
  if (condition) return;
  std::fprintf(stderr, "consumer: not true: %s\n", what);
  std::exit(1);
}

double bowl(double x, double y) {
  return (x - 0.3) * (x - 0.3) + 2.0 * (y - 0.6) * (y - 0.6);
}

}  // namespace

int main(int, char** arguments) {
  using namespace repose;
  const ParameterSpace space({{.name = "mu_s_pp", .lower = 0.1, .upper = 0.9},
                              {.name = "mu_r_pp", .lower = 0.2, .upper = 1.0}});
  const Matrix points = space.from_unit_rows(doe::latin_hypercube(30, 2, {.seed = 4}));
  std::vector<double> height;
  table::Table design;
  for (std::size_t k = 0; k < space.dimension(); ++k) {
    const auto column = points.col(static_cast<Eigen::Index>(k));
    design.add(table::factor_column(space.parameters()[k], {column.begin(), column.end()}));
  }
  for (const auto& point : points.rowwise()) height.push_back(bowl(point(0), point(1)));
  design.add({.name = "height_m", .unit = "m", .role = table::Role::response, .values = height});

  const table::Location place{std::filesystem::path(arguments[1]), ""};
  table::write_table(place, design);
  const table::Table back = table::read_table(place);
  require(back.names() == design.names(), "the table has the columns that were written");
  require(back.matrix(space.names()) == points, "the table has the values that were written");
  require(back.column("height_m").unit == "m", "a column keeps its unit");
  require(back.column("mu_s_pp").range == table::FactorRange{0.1, 0.9}, "a factor keeps its range");

  const opt::Bounds bounds{Vector{{0.1, 0.2}}, Vector{{0.9, 1.0}}};
  const std::vector<double> y = back.numbers("height_m");
  const auto model = surrogate::GaussianProcess::fit(
      back.matrix(space.names()),
      Eigen::Map<const Vector>(y.data(), static_cast<Eigen::Index>(y.size())), bounds,
      {.noise = surrogate::Noise::none});
  const opt::Minimum minimum =
      opt::minimize([&](const Vector& x, Vector*) { return model.predict(x).mean; },
                    Vector{{0.5, 0.5}}, bounds, {.algorithm = opt::Algorithm::bobyqa});
  // 30 points of a parabola in two dimensions: an interpolating process is good to a thousandth.
  require(std::abs(minimum.x(0) - 0.3) < 0.02 && std::abs(minimum.x(1) - 0.6) < 0.02,
          "the minimum of the model lies where that of the function lies");

  const doe::Design screening = doe::definitive_screening_design(5);
  require((screening.coded.colwise().sum().array() == 0.0).all(),
          "the columns of a definitive screening design are balanced");
  require(is_safe_with_other_alignment(), "matrices pass to and from code for a newer processor");
  return 0;
}
