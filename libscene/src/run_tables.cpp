#include "run_tables.hpp"

#include <array>

namespace repose::scene {
namespace {

namespace fs = std::filesystem;

/// Columns x_m, y_m, z_m and the like.
void add_vectors(table::Table& out, const char* prefix, const char* unit_suffix, const char* unit,
                 const std::vector<Vec3>& vectors) {
  const char* const axes[3] = {"x", "y", "z"};
  for (int k = 0; k < 3; ++k) {
    std::vector<double> values;
    values.reserve(vectors.size());
    for (const Vec3& v : vectors) values.push_back(v[k]);
    out.add({.name = std::string(prefix) + axes[k] + unit_suffix, .unit = unit, .values = values});
  }
}

std::vector<Vec3> read_vectors(const table::Table& in, const std::string& prefix,
                               const std::string& suffix) {
  const std::vector<double> x = in.numbers(prefix + "x" + suffix);
  const std::vector<double> y = in.numbers(prefix + "y" + suffix);
  const std::vector<double> z = in.numbers(prefix + "z" + suffix);
  std::vector<Vec3> vectors;
  vectors.reserve(x.size());
  for (std::size_t i = 0; i < x.size(); ++i) vectors.emplace_back(x[i], y[i], z[i]);
  return vectors;
}

struct EnergyTerm {
  const char* name;
  double EnergyRow::*value;
};
constexpr std::array<EnergyTerm, 16> kEnergyTerms = {{
    {"kinetic_translational_j", &EnergyRow::kinetic_translational_j},
    {"kinetic_rotational_j", &EnergyRow::kinetic_rotational_j},
    {"gravitational_j", &EnergyRow::gravitational_j},
    {"elastic_normal_j", &EnergyRow::elastic_normal_j},
    {"elastic_tangential_j", &EnergyRow::elastic_tangential_j},
    {"elastic_rolling_j", &EnergyRow::elastic_rolling_j},
    {"dissipated_normal_j", &EnergyRow::dissipated_normal_j},
    {"dissipated_tangential_j", &EnergyRow::dissipated_tangential_j},
    {"dissipated_sliding_j", &EnergyRow::dissipated_sliding_j},
    {"dissipated_rolling_j", &EnergyRow::dissipated_rolling_j},
    {"stiffness_change_j", &EnergyRow::stiffness_change_j},
    {"released_j", &EnergyRow::released_j},
    {"wall_work_j", &EnergyRow::wall_work_j},
    {"inserted_j", &EnergyRow::inserted_j},
    {"removed_j", &EnergyRow::removed_j},
    {"error_j", &EnergyRow::error_j},
}};

}  // namespace

std::vector<std::string> region_columns(const Case& scene) {
  std::vector<std::string> names;
  for (const Region& region : scene.regions) {
    names.push_back("mass_" + region.name + "_kg");
    for (const Material& material : scene.materials)
      names.push_back("mass_" + region.name + "_" + material.name + "_kg");
  }
  return names;
}

std::vector<ColumnHead> series_heads(const Case& scene) {
  std::vector<ColumnHead> heads{{"time_s", "s"},
                                {"kinetic_energy_j", "J"},
                                {"max_overlap_ratio"},
                                {"contacts", "1", ColumnType::integer}};
  for (const std::string& name : region_columns(scene)) heads.push_back({name, "kg"});
  return heads;
}

std::vector<ColumnHead> wall_heads(const Case& scene) {
  std::vector<ColumnHead> heads{{"time_s", "s"}};
  for (const Wall& wall : scene.walls) {
    for (const char* component : {"fx_", "fy_", "fz_"})
      heads.push_back({component + wall.name + "_n", "N"});
    for (const char* component : {"tx_", "ty_", "tz_"})
      heads.push_back({component + wall.name + "_n_m", "N m"});
  }
  return heads;
}

std::vector<ColumnHead> contact_heads(const Case& scene) {
  std::vector<ColumnHead> heads{{"time_s", "s"}};
  for (const PairCoefficients& pair : scene.pairs) {
    const std::string names = pair.first + "_" + pair.second;
    heads.push_back({"contacts_" + names, "1", ColumnType::integer});
    heads.push_back({"mean_normal_force_" + names + "_n", "N"});
    heads.push_back({"largest_normal_force_" + names + "_n", "N"});
    heads.push_back({"mean_overlap_ratio_" + names});
    heads.push_back({"sliding_fraction_" + names});
  }
  return heads;
}

std::vector<ColumnHead> energy_heads() {
  std::vector<ColumnHead> heads{{"time_s", "s"}};
  for (const EnergyTerm& term : kEnergyTerms) heads.push_back({term.name, "J"});
  return heads;
}

std::vector<double> values_of(const SeriesRow& row) {
  std::vector<double> values{row.time_s, row.kinetic_energy_j, row.max_overlap_ratio,
                             static_cast<double>(row.contacts)};
  values.insert(values.end(), row.region_mass_kg.begin(), row.region_mass_kg.end());
  return values;
}

std::vector<double> values_of(const WallRow& row) {
  std::vector<double> values{row.time_s};
  for (std::size_t w = 0; w < row.force_n.size(); ++w) {
    for (int k = 0; k < 3; ++k) values.push_back(row.force_n[w][k]);
    for (int k = 0; k < 3; ++k) values.push_back(row.torque_n_m.at(w)[k]);
  }
  return values;
}

std::vector<double> values_of(const ContactRow& row) {
  std::vector<double> values{row.time_s};
  for (const PairContacts& pair : row.pairs)
    values.insert(values.end(),
                  {static_cast<double>(pair.contacts), pair.mean_normal_force_n,
                   pair.largest_normal_force_n, pair.mean_overlap_ratio, pair.sliding_fraction});
  return values;
}

std::vector<double> values_of(const EnergyRow& row) {
  std::vector<double> values{row.time_s};
  for (const EnergyTerm& term : kEnergyTerms) values.push_back(row.*term.value);
  return values;
}

table::Table table_of(const Snapshot& s) {
  table::Table out;
  out.add({.name = "id", .role = table::Role::id, .values = s.id});
  out.add({.name = "body", .role = table::Role::group, .values = s.body});
  out.add({.name = "material", .values = s.material});
  out.add({.name = "radius_m", .unit = "m", .values = s.radius_m});
  out.add({.name = "mass_kg", .unit = "kg", .values = s.mass_kg});
  add_vectors(out, "", "_m", "m", s.position);
  add_vectors(out, "v", "_m_s", "m/s", s.velocity);
  add_vectors(out, "w", "_rad_s", "rad/s", s.angular_velocity);
  out.attributes["time_s"] = s.time_s;
  out.attributes["stage"] = s.stage;
  out.attributes["materials"] = s.materials;
  return out;
}

Snapshot snapshot_of(const table::Table& in, const fs::path& file) {
  Snapshot s;
  s.time_s = attribute<double>(in.attributes, "time_s", file);
  s.stage = attribute<std::string>(in.attributes, "stage", file);
  s.materials = attribute<std::vector<std::string>>(in.attributes, "materials", file);
  s.id = in.integers("id");
  s.body = in.integers("body");
  s.material = in.integers("material");
  s.radius_m = in.numbers("radius_m");
  s.mass_kg = in.numbers("mass_kg");
  s.position = read_vectors(in, "", "_m");
  s.velocity = read_vectors(in, "v", "_m_s");
  s.angular_velocity = read_vectors(in, "w", "_rad_s");
  return s;
}

table::Attributes attributes_of(const RunSummary& s, const std::string& case_text) {
  table::Attributes a;
  a["repose_run"] = std::int64_t{1};
  a["steps"] = s.steps;
  a["time_step_s"] = s.time_step_s;
  a["spheres"] = s.spheres;
  a["inserted"] = s.bodies.inserted;
  a["removed"] = s.bodies.removed;
  a["alive"] = s.bodies.alive;
  a["inserted_kg"] = s.bodies.inserted_kg;
  a["removed_kg"] = s.bodies.removed_kg;
  a["alive_kg"] = s.bodies.alive_kg;
  a["wall_time_s"] = s.wall_time_s;
  a["largest_overlap_ratio"] = s.largest_overlap_ratio;
  if (!s.state_hash.empty()) a["state_hash"] = s.state_hash;
  a["engine"] = s.engine;
  a["version"] = s.version;
  a["seed"] = static_cast<std::int64_t>(s.seed);
  a["finished"] = std::int64_t{1};
  a["case"] = case_text;
  std::vector<std::string> names, reasons;
  std::vector<double> times;
  for (const StageEnd& stage : s.stages) {
    names.push_back(stage.name);
    times.push_back(stage.time_s);
    reasons.push_back(stage.reason);
  }
  a["stage_names"] = names;
  a["stage_end_times_s"] = times;
  a["stage_end_reasons"] = reasons;
  return a;
}

RunSummary summary_of(const table::Attributes& a, const fs::path& file) {
  RunSummary s;
  s.steps = attribute<std::int64_t>(a, "steps", file);
  s.time_step_s = attribute<double>(a, "time_step_s", file);
  s.spheres = attribute<std::int64_t>(a, "spheres", file);
  s.bodies = {.inserted = attribute<std::int64_t>(a, "inserted", file),
              .removed = attribute<std::int64_t>(a, "removed", file),
              .alive = attribute<std::int64_t>(a, "alive", file),
              .inserted_kg = attribute<double>(a, "inserted_kg", file),
              .removed_kg = attribute<double>(a, "removed_kg", file),
              .alive_kg = attribute<double>(a, "alive_kg", file)};
  s.wall_time_s = attribute<double>(a, "wall_time_s", file);
  s.largest_overlap_ratio = attribute<double>(a, "largest_overlap_ratio", file);
  if (a.contains("state_hash")) s.state_hash = attribute<std::string>(a, "state_hash", file);
  s.engine = attribute<std::string>(a, "engine", file);
  s.version = attribute<std::string>(a, "version", file);
  s.seed = static_cast<std::uint64_t>(attribute<std::int64_t>(a, "seed", file));
  const auto names = attribute<std::vector<std::string>>(a, "stage_names", file);
  const auto times = attribute<std::vector<double>>(a, "stage_end_times_s", file);
  const auto reasons = attribute<std::vector<std::string>>(a, "stage_end_reasons", file);
  for (std::size_t i = 0; i < names.size(); ++i)
    s.stages.push_back({names[i], times.at(i), reasons.at(i)});
  return s;
}

}  // namespace repose::scene
