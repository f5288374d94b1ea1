// The tables [[kpi]] of a rig, and whether a case has what they name.
#include <fmt/format.h>

#include <algorithm>
#include <functional>
#include <set>

#include "repose/base/error.hpp"
#include "repose/base/text.hpp"
#include "repose/dem_adapter/kpi_definition.hpp"

namespace repose::dem_adapter {
namespace {

const Allowed kShare{.lower = 0.0, .upper = 1.0};
const std::vector<std::string> kGrids{"x", "y", "vertical", "radial", "circumferential", "cubic"};
const std::vector<std::string> kIndices{
    "rsd",         "panda_tan",       "li",   "mantravadi_tan", "variance_fraction",
    "ketterhagen", "ashton_valentin", "lacey"};

std::optional<double> number_if_any(const TomlTable& table, const char* key) {
  return table.has(key) ? std::optional(table.number(key)) : std::nullopt;
}

/// Both numbers of a pair of keys, or none.
std::optional<std::pair<double, double>> span_if_any(const TomlTable& table, const char* from,
                                                     const char* to, const Allowed& allowed = {}) {
  if (!table.has(from) && !table.has(to)) return std::nullopt;
  const std::pair span(table.number(from, allowed), table.number(to, allowed));
  if (!(span.first < span.second))
    table.fail(to, fmt::format("{} is not above {} = {}", shortest(span.second), from,
                               shortest(span.first)));
  return span;
}

EdgeOptions read_edge(const TomlTable& table) {
  EdgeOptions edge;
  const auto shape = table.choice_or("shape", "heap", {"heap", "slopes", "surface"});
  edge.shape = shape == "heap"     ? EdgeShape::heap
               : shape == "slopes" ? EdgeShape::slopes
                                   : EdgeShape::surface;
  if (edge.shape == EdgeShape::heap) {
    edge.axis_m = number_if_any(table, "axis_m");
    edge.floor_m = number_if_any(table, "floor_m");
    edge.toe_m = number_if_any(table, "toe_m");
    if (const auto part = span_if_any(table, "from_height", "to_height", kShare)) {
      edge.from = part->first;
      edge.to = part->second;
    }
  }
  if (edge.shape == EdgeShape::slopes) {
    edge.outlet_m = span_if_any(table, "outlet_left_m", "outlet_right_m");
    if (!edge.outlet_m) table.fail("", "shape = \"slopes\" needs outlet_left_m and outlet_right_m");
  }
  edge.fit = table.choice_or("fit", "robust", {"robust", "least-squares"}) == "robust"
                 ? LineFit::robust
                 : LineFit::least_squares;
  return edge;
}

KpiKind read_angle(const TomlTable& table) {
  AngleKpi kpi{.edge = read_edge(table)};
  const auto side = table.choice_or("side", "both", {"both", "left", "right"});
  kpi.side = side == "both" ? Side::both : side == "left" ? Side::left : Side::right;
  if (kpi.side != Side::both && kpi.edge.shape == EdgeShape::surface)
    table.fail("side", "a surface is one line and has no sides; leave it out");
  if (table.has("seen_along")) {
    kpi.seen_along.clear();
    for (const auto& axis : table.texts("seen_along")) {
      if (axis != "x" && axis != "y")
        table.fail("seen_along",
                   fmt::format("\"{}\" is not allowed; give \"x\", \"y\" or both", axis));
      kpi.seen_along.push_back(axis == "y" ? ViewDirection::along_y : ViewDirection::along_x);
    }
    if (kpi.seen_along.empty()) table.fail("seen_along", "is empty; give \"x\", \"y\" or both");
  }
  kpi.region = table.text_or("region", "");
  kpi.stage = table.text_or("stage", "");
  kpi.sampled = table.choice_or("sampled", "at-end", {"at-end", "throughout"}) == "at-end"
                    ? Sampled::at_end
                    : Sampled::throughout;
  kpi.fastest_m_s = table.number_or("fastest_m_s", kpi.fastest_m_s, kPositive);
  return kpi;
}

KpiKind read_mass_flow(const TomlTable& table) {
  MassFlowKpi kpi{.region = table.text("region"), .stage = table.text_or("stage", "")};
  kpi.flow.filter_s = table.number_or("filter_s", kpi.flow.filter_s, kNonNegative);
  const auto times = span_if_any(table, "from_s", "to_s", kNonNegative);
  const auto shares = span_if_any(table, "from_share", "to_share", kShare);
  if (times && shares)
    table.fail("from_s", "stands beside from_share; give a window in one of them");
  if (times) kpi.flow.window = TimeWindow{times->first, times->second};
  if (shares) kpi.flow.window = ShareWindow{shares->first, shares->second};
  kpi.jammed_below = table.number_or("jammed_below", 0.0, kShare);
  return kpi;
}

KpiKind read_mass(const TomlTable& table) {
  MassKpi kpi{.region = table.text("region"),
              .material = table.text_or("material", ""),
              .stage = table.text_or("stage", "")};
  if (table.has("time_s")) kpi.time_s = table.number("time_s", kNonNegative);
  return kpi;
}

KpiKind read_fraction(const TomlTable& table) {
  return FractionKpi{.region = table.text("region"),
                     .material = table.text_or("material", ""),
                     .stage = table.text_or("stage", ""),
                     .jammed_below = table.number_or("jammed_below", 0.0, kShare)};
}

KpiKind read_bulk_density(const TomlTable& table) {
  return BulkDensityKpi{.region = table.text("region"), .stage = table.text_or("stage", "")};
}

KpiKind read_segregation_over_time(const TomlTable& table) {
  return SegregationOverTimeKpi{.region = table.text("region"), .material = table.text("material")};
}

KpiKind read_grid_segregation(const TomlTable& table) {
  GridSegregationKpi kpi{.index = table.choice_or("index", "rsd", kIndices),
                         .region = table.text_or("region", ""),
                         .material = table.text("material"),
                         .stage = table.text_or("stage", "")};
  kpi.grid.kind = grid_kind(table.choice("grid", kGrids));
  if (table.has("bin")) kpi.grid.sizes = {table.number("bin", kPositive)};
  if (table.has("origin_m")) {
    const auto x = table.numbers("origin_m");
    if (x.size() != 3) table.fail("origin_m", "give three numbers, [x, y, z]");
    kpi.grid.origin = scene::Vec3{x[0], x[1], x[2]};
  }
  const auto basis = table.choice_or("basis", "mass", {"mass", "number", "volume"});
  kpi.grid.basis = basis == "mass"     ? Basis::mass
                   : basis == "number" ? Basis::number
                                       : Basis::volume;
  kpi.grid.least_fill = table.number_or("least_fill", 0.0, kNonNegative);
  return kpi;
}

KpiKind read_duration(const TomlTable& table) {
  DurationKpi kpi{.stage = table.text_or("stage", ""), .region = table.text_or("region", "")};
  if (table.has("share")) {
    kpi.share = table.number("share", {.lower = 0.0, .upper = 1.0, .open_lower = true});
    if (kpi.region.empty())
      table.fail("share", "is a share of what leaves a region; name it by the key region");
  }
  return kpi;
}

KpiKind read_wall_load(const TomlTable& table, WallLoadKpi::Load load) {
  WallLoadKpi kpi{.load = load, .wall = table.text("wall"), .stage = table.text_or("stage", "")};
  const auto component = table.choice("component", {"x", "y", "z", "norm"});
  using Component = WallLoadKpi::Component;
  kpi.component = component == "x"   ? Component::x
                  : component == "y" ? Component::y
                  : component == "z" ? Component::z
                                     : Component::norm;
  return kpi;
}

KpiKind read_contact_force(const TomlTable& table) {
  const auto materials = table.texts("materials");
  if (materials.size() != 2) table.fail("materials", "give the two of a pair, [\"a\", \"b\"]");
  return ContactForceKpi{
      .first = materials[0], .second = materials[1], .stage = table.text_or("stage", "")};
}

KpiKind read_formula(const TomlTable& table) {
  auto text = table.text("formula");
  if (!text.starts_with("=")) table.fail("formula", "must begin with =, as in \"= a / b\"");
  return FormulaKpi{.formula = text.substr(1)};
}

constexpr char kAnySuffix[] = "any";

/// A kind by its name in files, and the suffix of its KPIs' names.
struct KindOfKpi {
  const char* name;
  const char* suffix;
  std::function<KpiKind(const TomlTable&)> read;
};

const std::vector<KindOfKpi>& kinds() {
  using Load = WallLoadKpi::Load;
  static const std::vector<KindOfKpi> kKinds{
      {"angle", "_deg", read_angle},
      {"mass_flow", "_kg_s", read_mass_flow},
      {"mass", "_kg", read_mass},
      {"fraction", "", read_fraction},
      {"bulk_density", "_kg_m3", read_bulk_density},
      {"segregation_over_time", "", read_segregation_over_time},
      {"grid_segregation", "", read_grid_segregation},
      {"duration", "_s", read_duration},
      {"wall_force", "_n", [](const TomlTable& t) { return read_wall_load(t, Load::force); }},
      {"wall_torque", "_n_m", [](const TomlTable& t) { return read_wall_load(t, Load::torque); }},
      {"contact_force", "_n", read_contact_force},
      {"formula", kAnySuffix, read_formula}};
  return kKinds;
}

bool has_unit_of(const std::string& name, const std::string& suffix) {
  return suffix == kAnySuffix ||
         (name.ends_with(suffix) && label_of(name).unit == label_of("x" + suffix).unit);
}

KpiDefinition read_kpi(const TomlTable& table) {
  std::vector<std::string> names;
  for (const auto& kind : kinds()) names.push_back(kind.name);
  const auto wanted = table.choice("kind", names);
  const auto kind =
      std::find_if(kinds().begin(), kinds().end(), [&](const auto& k) { return k.name == wanted; });
  const auto name = table.text("name");
  const std::string suffix = kind->suffix;
  if (!has_unit_of(name, suffix))
    table.fail("name",
               fmt::format("\"{}\": the name of a KPI of kind {} {}", name, wanted,
                           suffix.empty() ? "ends with no unit: it has none"
                                          : fmt::format("must end with its unit, {}", suffix)));
  return {.name = name, .kind = kind->read(table)};
}

/// What check_kpi() looks for, one overload a kind.
struct Checker {
  const scene::Case& scene;

  template <class Items>
  static void require(const char* what, const std::string& name, const Items& items) {
    std::vector<std::string> known;
    for (const auto& item : items) known.push_back(item.name);
    if (name.empty() || std::find(known.begin(), known.end(), name) != known.end()) return;
    const auto similar = closest_name(name, known);
    throw InputError(fmt::format("there is no {} \"{}\"; {}", what, name,
                                 !similar.empty() ? "did you mean " + similar + "?"
                                 : known.empty()  ? "the case has none"
                                                  : "known are " + listed(known)));
  }
  void region(const std::string& name) const { require("region", name, scene.regions); }
  void stage(const std::string& name) const { require("stage", name, scene.stages); }
  void material(const std::string& name) const { require("material", name, scene.materials); }

  void operator()(const AngleKpi& kpi) const {
    region(kpi.region);
    stage(kpi.stage);
    if (kpi.sampled == Sampled::throughout && !(scene.output.snapshot_interval_s > 0.0))
      throw InputError(
          "sampled = \"throughout\" needs snapshots in between; give output.snapshot_interval_s");
  }
  void operator()(const MassFlowKpi& kpi) const {
    region(kpi.region);
    stage(kpi.stage);
  }
  void operator()(const MassKpi& kpi) const {
    region(kpi.region);
    material(kpi.material);
    stage(kpi.stage);
  }
  void operator()(const FractionKpi& kpi) const {
    region(kpi.region);
    material(kpi.material);
    stage(kpi.stage);
  }
  void operator()(const BulkDensityKpi& kpi) const {
    region(kpi.region);
    stage(kpi.stage);
    for (const auto& one : scene.regions)
      if (one.name == kpi.region && one.cylinder)
        throw InputError(fmt::format(
            "region \"{}\" is a cylinder; bulk density needs a box inside the bed", one.name));
  }
  void operator()(const SegregationOverTimeKpi& kpi) const {
    region(kpi.region);
    material(kpi.material);
  }
  void operator()(const GridSegregationKpi& kpi) const {
    region(kpi.region);
    material(kpi.material);
    stage(kpi.stage);
  }
  void operator()(const DurationKpi& kpi) const {
    region(kpi.region);
    stage(kpi.stage);
  }
  void operator()(const WallLoadKpi& kpi) const {
    stage(kpi.stage);
    if (scene::walls_named(scene, kpi.wall).empty()) require("wall", kpi.wall, scene.walls);
  }
  void operator()(const ContactForceKpi& kpi) const {
    stage(kpi.stage);
    for (const auto& name : {kpi.first, kpi.second}) scene::material_index(scene, name);
  }
  void operator()(const FormulaKpi&) const {}
};

}  // namespace

std::vector<KpiDefinition> read_kpis(const std::vector<TomlTable>& tables) {
  std::vector<KpiDefinition> kpis;
  std::set<std::string> names;
  for (const auto& table : tables) {
    kpis.push_back(read_kpi(table));
    if (!names.insert(kpis.back().name).second)
      table.fail("name", fmt::format("two KPIs are called {}; rename one", kpis.back().name));
  }
  return kpis;
}

void check_kpi(const KpiDefinition& kpi, const scene::Case& scene) {
  std::visit(Checker{scene}, kpi.kind);
}

}  // namespace repose::dem_adapter
