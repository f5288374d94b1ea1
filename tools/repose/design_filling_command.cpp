// repose design lhs|sobol|halton: points that fill the space of the parameters.
#include <fmt/format.h>

#include <memory>

#include "design_columns.hpp"
#include "design_table.hpp"
#include "repose/doe/space_filling.hpp"

namespace repose::cli {
namespace {

struct FillingOptions : DesignOptions {
  int points = 0;
  std::string variant;  ///< criterion or scrambling
};

int points_of(const FillingOptions& options, const ParameterSpace& space) {
  return options.points > 0 ? options.points : 10 * static_cast<int>(space.dimension());
}

void hypercube(const FillingOptions& options) {
  const auto space = read_factors(options.factors);
  using Criterion = doe::LatinHypercubeOptions::Criterion;
  const auto criterion = options.variant == "plain"     ? Criterion::plain
                         : options.variant == "maximin" ? Criterion::maximin
                                                        : Criterion::correlation;
  const Matrix unit = doe::latin_hypercube(
      points_of(options, space), static_cast<int>(space.dimension()),
      {.criterion = criterion, .seed = options.seed, .allowed = doe::constraint_filter(space)});
  finish(options, space, {.kind = "latin hypercube", .table = design_table(space, unit)});
}

void sobol(const FillingOptions& options) {
  const auto space = read_factors(options.factors);
  using Scrambling = doe::SobolOptions::Scrambling;
  const auto scrambling = options.variant == "none"    ? Scrambling::none
                          : options.variant == "shift" ? Scrambling::digital_shift
                                                       : Scrambling::owen;
  const Matrix unit = doe::sobol_points(
      points_of(options, space), static_cast<Eigen::Index>(space.dimension()),
      {.scrambling = scrambling, .seed = options.seed, .allowed = doe::constraint_filter(space)});
  finish(options, space, {.kind = "sobol sequence", .table = design_table(space, unit)});
}

void halton(const FillingOptions& options) {
  const auto space = read_factors(options.factors);
  using Scrambling = doe::HaltonOptions::Scrambling;
  const Matrix unit = doe::halton_points(
      points_of(options, space), static_cast<Eigen::Index>(space.dimension()),
      {.scrambling = options.variant == "none" ? Scrambling::none : Scrambling::permuted,
       .seed = options.seed,
       .allowed = doe::constraint_filter(space)});
  finish(options, space, {.kind = "halton sequence", .table = design_table(space, unit)});
}

void add_kind(CLI::App& group, const std::string& name, const std::string& description,
              const std::string& option, const std::vector<std::string>& variants,
              const std::string& what, void (*run)(const FillingOptions&)) {
  auto o = std::make_shared<FillingOptions>();
  o->variant = variants.front();
  auto* command =
      add_design_kind(group, name, description, "--factors factors.toml --points 64", *o);
  add_factors_file(*command, *o);
  command->add_option("--points", o->points, "runs; 10 for each factor unless given")
      ->check(CLI::Range(1, 1000000));
  command->add_option(option, o->variant, what)
      ->capture_default_str()
      ->check(CLI::IsMember(variants));
  command->callback([o, run] { run(*o); });
}

}  // namespace

void add_design_filling(CLI::App& group) {
  add_kind(group, "lhs", "Latin hypercube: one run in each of n cells of each factor",
           "--criterion", {"maximin", "plain", "correlation"}, "maximin, plain or correlation",
           hypercube);
  add_kind(group, "sobol", "Sobol' sequence: evenly spread, may be prolonged", "--scrambling",
           {"owen", "shift", "none"}, "owen, shift or none", sobol);
  add_kind(group, "halton", "Halton sequence: evenly spread, may be prolonged", "--scrambling",
           {"permuted", "none"}, "permuted or none", halton);
}

}  // namespace repose::cli
