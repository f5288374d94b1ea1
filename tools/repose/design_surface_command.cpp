// repose design central-composite|box-behnken: designs for quadratic models.
#include <fmt/format.h>

#include <cmath>
#include <memory>

#include "design_columns.hpp"
#include "design_table.hpp"
#include "repose/base/text.hpp"
#include "repose/doe/response_surface.hpp"

namespace repose::cli {
namespace {

struct SurfaceOptions : DesignOptions {
  std::string kind = "face-centred";
  std::string alpha = "rotatable";
  int centre_runs = 0;
};

/// The space with every range drawn out by `factor` about its middle, on its own scale.
ParameterSpace widened(const ParameterSpace& space, double factor) {
  auto parameters = space.parameters();
  for (auto& p : parameters) {
    if (p.scale == Scale::log) {
      const double half = 0.5 * std::log(p.upper / p.lower), middle = std::log(p.lower) + half;
      p.lower = std::exp(middle - factor * half);
      p.upper = std::exp(middle + factor * half);
    } else {
      const double half = 0.5 * (p.upper - p.lower), middle = p.lower + half;
      p.lower = middle - factor * half;
      p.upper = middle + factor * half;
    }
  }
  return ParameterSpace(std::move(parameters), space.fixed(), space.ties(), space.constraints());
}

void central_composite(const SurfaceOptions& options) {
  using Kind = doe::CentralCompositeOptions::Kind;
  using Alpha = doe::CentralCompositeOptions::Alpha;
  auto space = read_factors(options.factors);
  const bool faces = options.kind == "face-centred";
  require_levels(space, faces ? Needs::three_levels : Needs::any_distance,
                 "central composite design");
  // Circumscribed means inscribed in wider ranges: the runs are the same.
  const auto design = doe::central_composite(
      static_cast<int>(space.dimension()),
      {.kind = faces ? Kind::face_centred : Kind::inscribed,
       .alpha = options.alpha == "orthogonal" ? Alpha::orthogonal : Alpha::rotatable,
       .centre_runs = options.centre_runs});
  MadeDesign made{.kind = "central composite design", .table = {}};
  made.facts["alpha"] = design.alpha;
  made.lines.push_back(fmt::format("{}, alpha = {:.4f}, {} factorial runs", options.kind,
                                   design.alpha, design.factorial_runs));
  if (options.kind == "circumscribed") {
    space = widened(space, design.alpha);
    for (const auto& p : space.parameters())
      made.lines.push_back(
          fmt::format("axial runs take {} from {:.6g} to {:.6g}", p.name, p.lower, p.upper));
  }
  const auto order = run_order(design.coded.rows(), options);
  made.table = design_table(space, unit_of(design.coded(order, Eigen::all)));
  const auto axial_end = design.factorial_runs + 2 * static_cast<Eigen::Index>(space.dimension());
  std::vector<std::string> part;
  for (const auto run : order)
    part.emplace_back(run < design.factorial_runs ? "factorial"
                      : run < axial_end           ? "axial"
                                                  : "centre");
  made.table.add({.name = "part", .range = {}, .values = std::move(part)});
  finish(options, space, std::move(made));
}

void box_behnken(const SurfaceOptions& options) {
  const auto space = read_factors(options.factors);
  require_levels(space, Needs::three_levels, "Box-Behnken design");
  const Matrix coded = doe::box_behnken(static_cast<int>(space.dimension()),
                                        options.centre_runs > 0 ? options.centre_runs : -1);
  const auto order = run_order(coded.rows(), options);
  finish(options, space,
         {.kind = "Box-Behnken design",
          .table = design_table(space, unit_of(coded(order, Eigen::all)))});
}

}  // namespace

void add_design_surface(CLI::App& group) {
  auto c = std::make_shared<SurfaceOptions>();
  c->centre_runs = 4;
  auto* composite = add_design_kind(group, "central-composite",
                                    "Factorial, axial and centre runs for a quadratic model",
                                    "--factors factors.toml --kind inscribed", *c);
  add_factors_file(*composite, *c);
  composite
      ->add_option("--kind", c->kind,
                   "face-centred, inscribed, or circumscribed: axial runs\nbeyond the ranges")
      ->capture_default_str()
      ->check(CLI::IsMember({"face-centred", "inscribed", "circumscribed"}));
  composite->add_option("--alpha", c->alpha, "rotatable or orthogonal; unused if face-centred")
      ->capture_default_str()
      ->check(CLI::IsMember({"rotatable", "orthogonal"}));
  add_centre_runs(*composite, c->centre_runs, "runs at the middle, at least 1");
  add_run_order(*composite, *c);
  composite->callback([c] { central_composite(*c); });

  auto b = std::make_shared<SurfaceOptions>();
  auto* behnken = add_design_kind(group, "box-behnken",
                                  "Quadratic model without corners: 3 to 7 and 9 to 12 factors",
                                  "--factors factors.toml", *b);
  add_factors_file(*behnken, *b);
  behnken
      ->add_option("--centre-runs", b->centre_runs,
                   "runs at the middle; the published number unless "
                   "given")
      ->check(CLI::Range(1, 1000));
  add_run_order(*behnken, *b);
  behnken->callback([b] { box_behnken(*b); });
}

}  // namespace repose::cli
