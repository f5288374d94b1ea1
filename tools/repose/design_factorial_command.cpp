// repose design factorial|plackett-burman: two-level designs.
#include <fmt/format.h>

#include <algorithm>
#include <memory>

#include "design_columns.hpp"
#include "design_table.hpp"
#include "repose/base/error.hpp"
#include "repose/doe/factorial.hpp"

namespace repose::cli {
namespace {

struct FactorialOptions : DesignOptions {
  int runs = 0;
  int levels = 2;
  std::vector<std::string> generators;
  bool fold_over = false;
  int centre_runs = 0;
};

/// Runs at the middle of every factor below the others, then the order of runs.
Matrix with_centre_runs(const ParameterSpace& space, const Matrix& coded,
                        const FactorialOptions& options, const std::string& design) {
  if (options.centre_runs > 0)
    require_levels(space, Needs::three_levels, design + " with centre runs");
  Matrix all = Matrix::Zero(coded.rows() + options.centre_runs, coded.cols());
  all.topRows(coded.rows()) = coded;
  return all(run_order(all.rows(), options), Eigen::all);
}

std::string roman(int resolution) {
  constexpr const char* kRoman[] = {"", "I", "II", "III", "IV", "V", "VI", "VII", "VIII", "IX"};
  return resolution < 10 ? kRoman[resolution] : std::to_string(resolution);
}

void describe(const doe::FractionalFactorial& fraction, const ParameterSpace& space,
              MadeDesign& made) {
  constexpr std::size_t kMostWords = 15;
  std::vector<std::string> generators, words;
  for (std::size_t g = 0; g < fraction.generators.size(); ++g)
    generators.push_back(
        doe::product_name(doe::FactorProduct{1} << (fraction.base_factors + static_cast<int>(g))) +
        "=" + doe::product_name(fraction.generators[g]));
  for (const auto word : fraction.defining_relation) words.push_back(doe::product_name(word));
  made.facts.update({{"resolution", fraction.resolution},
                     {"generators", generators},
                     {"defining_relation", words},
                     {"minimum_aberration", fraction.is_minimum_aberration}});
  made.lines.push_back(fmt::format("resolution {}{}; generators {}", roman(fraction.resolution),
                                   fraction.is_minimum_aberration ? ", minimum aberration" : "",
                                   fmt::join(generators, ", ")));
  const std::size_t shown = std::min(words.size(), kMostWords);
  made.lines.push_back(fmt::format(
      "I = {}{}", fmt::join(words.begin(), words.begin() + static_cast<long>(shown), " = "),
      shown < words.size() ? fmt::format(" and {} more", words.size() - shown) : ""));
  for (std::size_t j = 0; j < space.dimension(); ++j)
    made.lines.push_back(
        fmt::format("{} {}", doe::product_name(doe::FactorProduct{1} << j), space.names()[j]));
}

/// Levels of each factor in a full factorial: of a list all, of others as many as asked for.
std::vector<int> levels_of(const ParameterSpace& space, int levels) {
  std::vector<int> result;
  for (const auto& p : space.parameters()) {
    const bool is_list = p.kind == ParameterKind::levels || p.kind == ParameterKind::categorical;
    if (p.kind == ParameterKind::integer &&
        (level_count(p) - 1) % static_cast<std::size_t>(levels - 1) != 0)
      throw InputError(
          fmt::format("parameter {}: {} whole numbers do not have {} equally spaced levels; change "
                      "its range or --levels",
                      p.name, level_count(p), levels));
    result.push_back(is_list ? static_cast<int>(level_count(p)) : levels);
  }
  return result;
}

void factorial(const FactorialOptions& options) {
  const auto space = read_factors(options.factors);
  const int k = static_cast<int>(space.dimension());
  const bool is_fraction = options.runs > 0 || !options.generators.empty();
  MadeDesign made{.kind = is_fraction ? "fractional factorial" : "full factorial", .table = {}};
  Matrix coded;
  if (is_fraction) {
    require_levels(space, Needs::two_levels, made.kind);
    const auto fraction = options.generators.empty()
                              ? doe::minimum_aberration(k, options.runs)
                              : doe::fractional_factorial(k, options.generators);
    describe(fraction, space, made);
    coded = fraction.coded;
  } else {
    coded = doe::full_factorial(levels_of(space, options.levels));
  }
  made.table = design_table(space, unit_of(with_centre_runs(space, coded, options, made.kind)));
  finish(options, space, std::move(made));
}

void plackett_burman(const FactorialOptions& options) {
  const auto space = read_factors(options.factors);
  const std::string kind = "Plackett-Burman design";
  require_levels(space, Needs::two_levels, kind);
  const Matrix coded = doe::plackett_burman(
      static_cast<int>(space.dimension()),
      options.fold_over ? doe::FoldOverRuns::appended : doe::FoldOverRuns::none);
  finish(options, space,
         {.kind = kind,
          .table = design_table(space, unit_of(with_centre_runs(space, coded, options, kind))),
          .lines = {options.fold_over ? "main effects are clear of interactions of two factors"
                                      : "main effects are mixed with interactions; --fold-over "
                                        "separates them"}});
}

}  // namespace

void add_design_factorial(CLI::App& group) {
  auto f = std::make_shared<FactorialOptions>();
  auto* full = add_design_kind(group, "factorial",
                               "All combinations of levels, or a regular two-level fraction",
                               "--factors factors.toml --runs 16", *f);
  add_factors_file(*full, *f);
  auto* levels = full->add_option("--levels", f->levels,
                                  "of each range in a full factorial; lists keep theirs")
                     ->capture_default_str()
                     ->check(CLI::Range(2, 100));
  auto* runs =
      full->add_option("--runs", f->runs, "a power of two: the fraction of minimum aberration");
  full->add_option("--generators", f->generators,
                   "of a fraction, e.g. E=ABC,F=BCD; factors are A, B,\n... without I")
      ->delimiter(',')
      ->excludes(runs)
      ->excludes(levels);
  runs->excludes(levels);
  add_centre_runs(*full, f->centre_runs, "runs at the middle");
  add_run_order(*full, *f);
  full->callback([f] { factorial(*f); });

  auto p = std::make_shared<FactorialOptions>();
  auto* burman = add_design_kind(group, "plackett-burman",
                                 "Two levels, runs the next multiple of four: main effects only",
                                 "--factors factors.toml --fold-over", *p);
  add_factors_file(*burman, *p);
  burman->add_flag("--fold-over", p->fold_over, "append the mirror image of every run");
  add_centre_runs(*burman, p->centre_runs, "runs at the middle");
  add_run_order(*burman, *p);
  burman->callback([p] { plackett_burman(*p); });
}

}  // namespace repose::cli
