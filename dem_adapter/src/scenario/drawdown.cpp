#include "repose/dem_adapter/drawdown.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <set>

#include "repose/base/error.hpp"
#include "repose/base/text.hpp"

namespace repose::dem_adapter {
namespace {

constexpr double kWallStiffness = 100.0;  // walls' Young's modulus over the particles'
constexpr double kWallPoisson = 0.3;
constexpr double kWallDensity_kg_m3 = 7800.0;
constexpr double kLowerWallGap_m =
    0.02;  // the lower box's walls end this far below the upper floor
constexpr char kBoxSymbol[] = "g";

/// The numbers of a draw-down that a study may vary, by the name they have in files.
std::map<std::string, double Drawdown::*> settings() {
  return {{"width_m", &Drawdown::width_m},
          {"outlet_m", &Drawdown::outlet_m},
          {"thickness_m", &Drawdown::thickness_m},
          {"drop_m", &Drawdown::drop_m},
          {"lower_width_m", &Drawdown::lower_width_m},
          {"mass_per_thickness_kg_m", &Drawdown::mass_per_thickness_kg_m},
          {"shear_modulus_pa", &Drawdown::shear_modulus_pa},
          {"time_step_rayleigh_fraction", &Drawdown::time_step_rayleigh_fraction}};
}

/// "pp", "ps", "pg", ...: each pair of symbols once, boxes last.
std::vector<std::string> pair_symbols(const Drawdown& rig) {
  std::vector<std::string> pairs;
  for (std::size_t i = 0; i < rig.materials.size(); ++i)
    for (std::size_t j = i; j < rig.materials.size(); ++j)
      pairs.push_back(rig.materials[i].symbol + rig.materials[j].symbol);
  for (const auto& material : rig.materials) pairs.push_back(material.symbol + kBoxSymbol);
  return pairs;
}

double coefficient(const Drawdown& rig, const std::string& kind, const std::string& pair) {
  if (const auto it = rig.coefficients.find(kind + "_" + pair); it != rig.coefficients.end())
    return it->second;
  if (pair[0] != pair[1] && pair.substr(1) != kBoxSymbol)  // the mean rule of two materials
    return 0.5 * (coefficient(rig, kind, {pair[0], pair[0]}) +
                  coefficient(rig, kind, {pair[1], pair[1]}));
  throw InputError(
      fmt::format("the draw-down scenario has no coefficient {}_{}; give it a value", kind, pair));
}

void refuse(const std::string& name, double value, const std::string& allowed) {
  throw InputError(
      fmt::format("draw-down: {} = {}: it must be {}", name, shortest(value), allowed));
}

void check(const Drawdown& rig) {
  for (const auto& [name, member] : settings())
    if (!(rig.*member > 0.0) || !std::isfinite(rig.*member)) refuse(name, rig.*member, "above 0");
  if (rig.outlet_m >= rig.width_m)
    refuse("outlet_m", rig.outlet_m, fmt::format("below width_m = {}", shortest(rig.width_m)));
  if (rig.lower_width_m < rig.outlet_m)
    refuse("lower_width_m", rig.lower_width_m,
           fmt::format("at least outlet_m = {}", shortest(rig.outlet_m)));
  if (rig.drop_m <= kLowerWallGap_m)
    refuse("drop_m", rig.drop_m, "above 0.02, the gap between the boxes");
  if (rig.materials.empty())
    throw InputError("draw-down: no material; give at least one [[material]]");
  std::set<std::string> symbols{kBoxSymbol}, names;
  double share = 0.0;
  for (const auto& material : rig.materials) {
    if (material.symbol.size() != 1 || !symbols.insert(material.symbol).second)
      throw InputError(
          fmt::format("draw-down: material {} has the symbol \"{}\": it must be one letter that "
                      "no other material has, and not g, the boxes",
                      material.name, material.symbol));
    if (!names.insert(material.name).second)
      throw InputError(fmt::format("draw-down: material {} is given twice", material.name));
    if (std::find(rig.layers.begin(), rig.layers.end(), material.name) == rig.layers.end())
      throw InputError(fmt::format(
          "draw-down: material {} is in no layer; add it to layers or remove it", material.name));
    share += material.mass_share;
  }
  if (std::abs(share - 1.0) > 1e-6) refuse("the sum of mass_share over materials", share, "1");
  for (const auto& layer : rig.layers)
    if (names.count(layer) == 0)
      throw InputError(
          fmt::format("draw-down: layer of {}: there is no such material; known are {}", layer,
                      listed({names.begin(), names.end()})));
}

scene::Wall rectangle(std::string name, double x0, double z0, double x1, double z1,
                      double thickness) {
  scene::Wall wall;
  wall.name = std::move(name);
  wall.material = "box";
  wall.shape = scene::Rectangle{
      .origin = {x0, 0.0, z0}, .edge_u = {x1 - x0, 0.0, z1 - z0}, .edge_v = {0.0, thickness, 0.0}};
  return wall;
}

scene::Wall plane(std::string name, const scene::Vec3& origin, const scene::Vec3& normal) {
  scene::Wall wall;
  wall.name = std::move(name);
  wall.material = "box";
  wall.shape = scene::Plane{.origin = origin, .normal = normal};
  return wall;
}

/// Height of the loose column, bottom to top.
double column_height(const Drawdown& rig) {
  double volume_per_thickness = 0.0;
  for (const auto& material : rig.materials)
    volume_per_thickness +=
        rig.mass_per_thickness_kg_m * material.mass_share / material.density_kg_m3;
  return volume_per_thickness / (rig.width_m * rig.solid_fraction);
}

double largest_diameter(const Drawdown& rig) {
  double largest = 0.0;
  for (const auto& material : rig.materials)
    for (const auto& size : material.sizes) largest = std::max(largest, size.upper_diameter_m);
  return largest;
}

std::vector<scene::Wall> walls_of(const Drawdown& rig, double top) {
  const double half = 0.5 * rig.width_m, slot = 0.5 * rig.outlet_m, lower = 0.5 * rig.lower_width_m;
  const double t = rig.thickness_m;
  std::vector<scene::Wall> walls{
      rectangle("upper_left", -half, 0.0, -half, top, t),
      rectangle("upper_right", half, 0.0, half, top, t),
      rectangle("floor_left", -half, 0.0, -slot, 0.0, t),
      rectangle("floor_right", slot, 0.0, half, 0.0, t),
      rectangle("gate", -slot, 0.0, slot, 0.0, t),
      plane("lower_floor", {0.0, 0.0, -rig.drop_m}, {0.0, 0.0, 1.0}),
      rectangle("lower_left", -lower, -rig.drop_m, -lower, -kLowerWallGap_m, t),
      rectangle("lower_right", lower, -rig.drop_m, lower, -kLowerWallGap_m, t)};
  if (rig.front == DrawdownFront::walls) {
    walls.push_back(plane("front", {0.0, 0.0, 0.0}, {0.0, 1.0, 0.0}));
    walls.push_back(plane("back", {0.0, t, 0.0}, {0.0, -1.0, 0.0}));
  }
  return walls;
}

std::vector<scene::Layer> layers_of(const Drawdown& rig) {
  std::vector<scene::Layer> layers;
  for (const auto& name : rig.layers) {
    const auto& material = *std::find_if(rig.materials.begin(), rig.materials.end(),
                                         [&](const auto& m) { return m.name == name; });
    const auto of_this =
        static_cast<double>(std::count(rig.layers.begin(), rig.layers.end(), name));
    layers.push_back(
        {.mass_kg = rig.mass_per_thickness_kg_m * rig.thickness_m * material.mass_share / of_this,
         .mixture = {{.material = name, .clump = material.clump, .sizes = material.sizes}}});
  }
  return layers;
}

DrawdownMaterial pellets(double small_m, double large_m, double share) {
  return {.name = "pellet",
          .symbol = "p",
          .density_kg_m3 = 3602.0,
          .poissons_ratio = 0.25,
          .mass_share = share,
          .sizes = {{small_m, small_m, 0.48}, {large_m, large_m, 0.52}}};
}

DrawdownMaterial sinter(double small_m, double large_m, double small_share, double share) {
  return {.name = "sinter",
          .symbol = "s",
          .density_kg_m3 = 3449.0,
          .poissons_ratio = 0.25,
          .mass_share = share,
          .sizes = {{small_m, small_m, small_share}, {large_m, large_m, 1.0 - small_share}}};
}

std::vector<scene::SizeClass> read_sizes(const TomlTable& material) {
  std::vector<scene::SizeClass> sizes;
  for (const auto& size : material.tables("sizes")) {
    scene::SizeClass c;
    if (size.has("diameter_m")) {
      c.lower_diameter_m = c.upper_diameter_m = size.number("diameter_m", kPositive);
    } else {
      c.lower_diameter_m = size.number("lower_diameter_m", kPositive);
      c.upper_diameter_m = size.number("upper_diameter_m", {.lower = c.lower_diameter_m});
    }
    c.mass_fraction =
        size.number("mass_fraction", {.lower = 0.0, .upper = 1.0, .open_lower = true});
    sizes.push_back(c);
  }
  if (sizes.empty()) material.fail("", "the key sizes is missing; give at least one size");
  return sizes;
}

/// A shipped shape: a scenario has no place for shapes of its own.
std::string read_clump(const TomlTable& material) {
  if (!material.has("clump")) return "";
  std::vector<std::string> names;
  for (const scene::ClumpShape& shape : scene::shipped_clumps()) names.push_back(shape.name);
  return material.choice("clump", names);
}

}  // namespace

Drawdown Drawdown::preset(const std::string& name) {
  Drawdown rig;
  rig.layers = {"pellet", "sinter", "pellet", "sinter"};
  // Table 5.9, run 4, of [Hadi2026]; what was not calibrated there: middle levels of Table 5.4.
  rig.coefficients = {{"mu_s_pp", 0.74}, {"mu_r_pp", 0.12}, {"c_r_pp", 0.76},  {"mu_s_ss", 0.90},
                      {"mu_r_ss", 0.08}, {"c_r_ss", 0.35},  {"mu_s_pg", 0.90}, {"mu_r_pg", 0.16},
                      {"c_r_pg", 0.70},  {"mu_s_sg", 0.83}, {"mu_r_sg", 0.08}, {"c_r_sg", 0.40}};
  if (name == "quick") {
    rig.materials = {pellets(0.010, 0.012, 0.5), sinter(0.009, 0.011, 0.60, 0.5)};
  } else if (name == "delft-like") {
    rig.width_m = 0.36;
    rig.outlet_m = 0.080;
    rig.thickness_m = 0.15;
    rig.front = DrawdownFront::walls;
    rig.drop_m = 0.45;
    rig.lower_width_m = 1.00;
    rig.mass_per_thickness_kg_m = 40.0 / 0.15;
    rig.materials = {pellets(0.012, 0.014, 0.5), sinter(0.012, 0.014, 0.75, 0.5)};
    rig.solid_fraction = 0.30;
    rig.shear_modulus_pa = 5e6;
    rig.settle_s = 0.45;
    rig.discharge_s = 4.0;
  } else {
    throw InputError(
        fmt::format("draw-down: there is no preset \"{}\"; choose quick or delft-like", name));
  }
  return rig;
}

Drawdown Drawdown::read(const TomlTable& table) {
  Drawdown rig = preset(table.choice_or("preset", "quick", {"quick", "delft-like"}));
  for (const auto& [name, member] : settings())
    rig.*member = table.number_or(name, rig.*member, kPositive);
  rig.front = table.choice_or("front", rig.front == DrawdownFront::periodic ? "periodic" : "walls",
                              {"periodic", "walls"}) == "periodic"
                  ? DrawdownFront::periodic
                  : DrawdownFront::walls;
  rig.solid_fraction =
      table.number_or("solid_fraction", rig.solid_fraction, {.lower = 0.05, .upper = 0.36});
  rig.settle_s = table.number_or("settle_s", rig.settle_s, kPositive);
  if (const auto all = table.table_if_present("settle_coefficients"))
    rig.settle_coefficients = scene::StageCoefficients{
        .restitution = all->number("restitution", {.lower = 0.0, .upper = 1.0, .open_lower = true}),
        .mu_s = all->number("mu_s", kNonNegative),
        .mu_r = all->number("mu_r", kNonNegative)};
  rig.discharge_s = table.number_or("discharge_s", rig.discharge_s, kPositive);
  if (table.has("layers")) rig.layers = table.texts("layers");
  if (const auto materials = table.tables("material"); !materials.empty()) {
    rig.materials.clear();
    for (const auto& m : materials)
      rig.materials.push_back(
          {.name = m.text("name"),
           .symbol = m.text("symbol"),
           .density_kg_m3 = m.number("density_kg_m3", kPositive),
           .poissons_ratio = m.number_or("poissons_ratio", 0.25, {.lower = 0.0, .upper = 0.5}),
           .mass_share = m.number("mass_share", {.lower = 0.0, .upper = 1.0, .open_lower = true}),
           .sizes = read_sizes(m),
           .clump = read_clump(m)});
  }
  if (const auto shares = table.table_if_present("mass_shares"))
    for (auto& material : rig.materials)
      material.mass_share = shares->number(material.name, {.lower = 0.0, .upper = 1.0});
  if (const auto given = table.table_if_present("coefficients")) {
    const auto known = rig.parameter_names();
    for (const auto& key : given->keys()) {
      if (std::find(known.begin(), known.end(), key) == known.end() || settings().count(key) > 0)
        given->fail(key, fmt::format("there is no such coefficient; known are {}", listed(known)));
      rig.coefficients[key] = given->number(key, kNonNegative);
    }
  }
  try {
    check(rig);
  } catch (const InputError& error) {
    table.fail("", error.what());
  }
  return rig;
}

std::vector<std::string> Drawdown::parameter_names() const {
  std::vector<std::string> names;
  for (const auto& pair : pair_symbols(*this))
    for (const char* kind : {"mu_s_", "mu_r_", "c_r_"}) names.push_back(kind + pair);
  for (const auto& [name, member] : settings()) names.push_back(name);
  return names;
}

std::vector<std::string> Drawdown::kpi_names() const {
  return {"shear_angle_deg", "angle_of_repose_deg", "discharged_fraction", "discharged_mass_kg",
          "mass_flow_kg_s"};
}

scene::Case Drawdown::make_case(const ParameterValues& values, std::uint64_t seed) const {
  Drawdown rig = *this;
  const auto members = settings();
  const auto names = parameter_names();
  for (const auto& [name, value] : values) {
    if (const auto it = members.find(name); it != members.end())
      rig.*(it->second) = value;
    else if (std::find(names.begin(), names.end(), name) != names.end())
      rig.coefficients[name] = value;
  }
  check(rig);

  const double top = column_height(rig) * 1.25 + 2.0 * largest_diameter(rig);
  const double margin = 2.0 * largest_diameter(rig);
  const double half_domain = 0.5 * std::max(rig.lower_width_m, rig.width_m) + margin;
  scene::Case c;
  c.seed = seed;
  c.time_step_rayleigh_fraction = rig.time_step_rayleigh_fraction;
  c.lower_m = {-half_domain, 0.0, -rig.drop_m - margin};
  c.upper_m = {half_domain, rig.thickness_m, top + margin};
  c.periodic.y = rig.front == DrawdownFront::periodic;
  for (const auto& m : rig.materials)
    c.materials.push_back({m.name, m.density_kg_m3,
                           2.0 * rig.shear_modulus_pa * (1.0 + m.poissons_ratio),
                           m.poissons_ratio});
  c.materials.push_back({"box", kWallDensity_kg_m3,
                         kWallStiffness * 2.0 * rig.shear_modulus_pa * (1.0 + kWallPoisson),
                         kWallPoisson});
  const auto name_of = [&](char symbol) -> std::string {
    for (const auto& m : rig.materials)
      if (m.symbol[0] == symbol) return m.name;
    return "box";
  };
  for (const auto& pair : pair_symbols(rig))
    c.pairs.push_back({.first = name_of(pair[0]),
                       .second = name_of(pair[1]),
                       .restitution = coefficient(rig, "c_r", pair),
                       .mu_s = coefficient(rig, "mu_s", pair),
                       .mu_r = coefficient(rig, "mu_r", pair)});
  c.walls = walls_of(rig, top);
  constexpr double kFar = std::numeric_limits<double>::infinity();
  c.regions = {{"upper_box", {-kFar, -kFar, 0.0}, {kFar, kFar, kFar}}};
  const double half = 0.5 * rig.width_m;
  c.fill = scene::Fill{.lower = {-half, 0.0, 0.0},
                       .upper = {half, rig.thickness_m, top},
                       .solid_fraction = rig.solid_fraction,
                       .layers = layers_of(rig)};
  c.stages = {
      {.name = "settle", .duration_s = rig.settle_s, .coefficients = rig.settle_coefficients},
      {.name = "discharge",
       .opens = {"gate"},
       .duration_s = rig.discharge_s,
       .minimum_s = std::min(0.5, rig.discharge_s),
       .at_rest = {},
       .flow_ends = scene::FlowEnds{.region = "upper_box", .fraction = 0.005, .window_s = 0.25}}};
  return c;
}

}  // namespace repose::dem_adapter
