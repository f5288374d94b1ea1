// Reading and writing of case files.
#include <algorithm>
#include <cctype>

#include "case_io/parts.hpp"
#include "repose/base/error.hpp"
#include "repose/base/file.hpp"
#include "repose/scene/case.hpp"

namespace repose::scene {
namespace {

void read_run(const TomlTable& table, Case& scene) {
  scene.seed = static_cast<std::uint64_t>(table.integer_or("seed", 1, kNonNegative));
  scene.time_step_rayleigh_fraction =
      table.number_or("time_step_rayleigh_fraction", scene.time_step_rayleigh_fraction, kPositive);
}

void read_domain(const TomlTable& table, Case& scene) {
  scene.lower_m = vector3(table, "lower_m");
  scene.upper_m = vector3(table, "upper_m");
  for (const std::string& axis : texts_or_none(table, "periodic")) {
    if (axis == "x")
      scene.periodic.x = true;
    else if (axis == "y")
      scene.periodic.y = true;
    else if (axis == "z")
      scene.periodic.z = true;
    else
      table.fail("periodic", "\"" + axis + "\" is not a direction; name \"x\", \"y\" or \"z\"");
  }
}

/// Appends what `read` makes of each table of an array.
template <class Item, class Read>
void read_each(const TomlTable& root, const char* key, std::vector<Item>& items, Read read) {
  for (const TomlTable& table : root.tables(key)) items.push_back(read(table));
}

void read_geometry(const TomlTable& root, const Folder& folder, Case& scene) {
  read_each(root, "wall", scene.walls, [&](const TomlTable& t) { return read_wall(t, folder); });
  for (const TomlTable& table : root.tables("box"))
    for (const Wall& wall : read_box(table)) scene.walls.push_back(wall);
  read_each(root, "motion", scene.motions, read_motion);
  read_each(root, "region", scene.regions, read_region);
}

void read_insertion(const TomlTable& root, const Folder& folder, Case& scene) {
  if (const auto fill = root.table_if_present("fill")) scene.fill = read_fill(*fill);
  read_each(root, "rain", scene.rains, read_rain);
  read_each(root, "particle_table", scene.particle_tables,
            [&](const TomlTable& t) { return read_particle_table(t, folder); });
  read_each(root, "particle", scene.particles, read_particle);
}

/// Whether TOML takes it without quotes.
bool is_bare_key(const std::string& key) {
  return !key.empty() && std::all_of(key.begin(), key.end(), [](unsigned char c) {
    return std::isalnum(c) != 0 || c == '_' || c == '-';
  });
}

void write_parameters(CaseText& out, const Case& scene) {
  if (scene.parameters.empty()) return;
  out.heading("[parameters]");
  for (const auto& [name, value] : scene.parameters)
    out.put(is_bare_key(name) ? name : toml_quoted(name), value);
}

void write_head(CaseText& out, const Case& scene) {
  out.put("gravity_m_s2", scene.gravity_m_s2);
  out.heading("[run]");
  out.raw("seed", std::to_string(scene.seed));
  out.put("time_step_rayleigh_fraction", scene.time_step_rayleigh_fraction);
  out.heading("[domain]");
  out.put("lower_m", scene.lower_m);
  out.put("upper_m", scene.upper_m);
  std::vector<std::string> periodic;
  if (scene.periodic.x) periodic.push_back("x");
  if (scene.periodic.y) periodic.push_back("y");
  if (scene.periodic.z) periodic.push_back("z");
  out.put("periodic", periodic);
}

}  // namespace

Case case_from(const TomlTable& root, const std::filesystem::path& folder) {
  Case scene;
  scene.gravity_m_s2 = vector3_or(root, "gravity_m_s2", scene.gravity_m_s2);
  if (const auto run = root.table_if_present("run")) read_run(*run, scene);
  read_domain(root.table("domain"), scene);
  if (const auto contact = root.table_if_present("contact")) scene.contact = read_contact(*contact);
  read_each(root, "material", scene.materials, read_material);
  read_each(root, "pair", scene.pairs, read_pair);
  read_each(root, "clump", scene.clumps, read_clump);
  read_geometry(root, folder, scene);
  read_insertion(root, folder, scene);
  read_each(root, "stage", scene.stages, read_stage);
  if (const auto output = root.table_if_present("output")) scene.output = read_output(*output);
  if (const auto parameters = root.table_if_present("parameters"))
    for (const std::string& name : parameters->keys())
      scene.parameters[name] = parameters->number(name);
  root.refuse_unknown_keys();
  try {
    validate(scene);
  } catch (const InputError& error) {
    throw InputError(root.file() + ": " + error.what());
  }
  return scene;
}

Case read_case(const std::filesystem::path& path) {
  return case_from(TomlTable::read_file(path), std::filesystem::absolute(path).parent_path());
}

Case parse_case(std::string_view text, const std::string& name) {
  return case_from(TomlTable::parse(text, name), {});
}

std::string case_text(const Case& scene) {
  CaseText out{"# A case of repose-dem.\n"};
  write_head(out, scene);
  write_contact(out, scene.contact);
  write_materials(out, scene);
  for (const ClumpShape& clump : scene.clumps) write_clump(out, clump);
  for (const Wall& wall : scene.walls) write_wall(out, wall);
  for (const Motion& motion : scene.motions) write_motion(out, motion);
  for (const Region& region : scene.regions) write_region(out, region);
  write_insertion(out, scene);
  for (const Stage& stage : scene.stages) write_stage(out, stage);
  write_output(out, scene.output);
  write_parameters(out, scene);
  return out.text;
}

void write_case(const std::filesystem::path& path, const Case& scene) {
  write_file_atomically(path, case_text(scene));
}

}  // namespace repose::scene
