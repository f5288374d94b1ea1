#include "repose/scene/run_output.hpp"

#include <fmt/format.h>

#include <cstdio>
#include <system_error>
#include <utility>

#include "repose/base/error.hpp"
#include "repose/base/file.hpp"
#include "repose/base/text.hpp"
#include "repose/table/io.hpp"

namespace repose::scene {
namespace {

namespace fs = std::filesystem;

constexpr std::size_t kRowsOfAChunk = 4096;

std::string numbered(const char* stem, int number) {
  return fmt::format("{}_{:06}.h5", stem, number);
}
std::string snapshot_group(std::size_t i) {
  return fmt::format("/snapshots/{:06}", i + 1);
}

void remove_tree(const fs::path& path) {
  std::error_code error;
  fs::remove_all(path, error);
  if (error)
    throw StorageError(path.string() + ": cannot be removed: " + error.message() +
                       "; remove it by hand or choose another folder");
}

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

table::Table table_of(const Snapshot& s) {
  table::Table out;
  out.add({.name = "id", .role = table::Role::id, .values = s.id});
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

/// An attribute of a given type.
template <class T>
T attribute(const table::Attributes& attributes, const std::string& name, const fs::path& file) {
  const auto found = attributes.find(name);
  if (found == attributes.end())
    throw StorageError(file.string() + ": attribute \"" + name +
                       "\" is missing; this is not a run of repose");
  if (const T* value = std::get_if<T>(&found->second)) return *value;
  throw StorageError(file.string() + ": attribute \"" + name +
                     "\" has another type than a run of repose");
}

Snapshot snapshot_of(const table::Table& in, const fs::path& file) {
  Snapshot s;
  s.time_s = attribute<double>(in.attributes, "time_s", file);
  s.stage = attribute<std::string>(in.attributes, "stage", file);
  s.materials = attribute<std::vector<std::string>>(in.attributes, "materials", file);
  s.id = in.integers("id");
  s.material = in.integers("material");
  s.radius_m = in.numbers("radius_m");
  s.mass_kg = in.numbers("mass_kg");
  s.position = read_vectors(in, "", "_m");
  s.velocity = read_vectors(in, "v", "_m_s");
  s.angular_velocity = read_vectors(in, "w", "_rad_s");
  return s;
}

table::Table table_of(const std::vector<SeriesRow>& rows,
                      const std::vector<std::string>& region_names) {
  std::vector<double> time, energy, overlap;
  std::vector<std::int64_t> contacts;
  std::vector<std::vector<double>> masses(region_names.size());
  for (const SeriesRow& row : rows) {
    time.push_back(row.time_s);
    energy.push_back(row.kinetic_energy_j);
    overlap.push_back(row.max_overlap_ratio);
    contacts.push_back(row.contacts);
    for (std::size_t c = 0; c < masses.size(); ++c) masses[c].push_back(row.region_mass_kg.at(c));
  }
  table::Table out;
  out.add({.name = "time_s", .unit = "s", .values = time});
  out.add({.name = "kinetic_energy_j", .unit = "J", .values = energy});
  out.add({.name = "max_overlap_ratio", .values = overlap});
  out.add({.name = "contacts", .values = contacts});
  for (std::size_t c = 0; c < masses.size(); ++c)
    out.add({.name = region_names[c], .unit = "kg", .values = masses[c]});
  return out;
}

template <class T>
void append(table::Values& to, const table::Values& from) {
  auto& target = std::get<std::vector<T>>(to);
  const auto& source = std::get<std::vector<T>>(from);
  target.insert(target.end(), source.begin(), source.end());
}

/// Rows of all chunks as one table.
table::Table joined(const std::vector<table::Table>& chunks) {
  table::Table out;
  for (const table::Column& column : chunks.front().columns()) {
    table::Column all = column;
    for (std::size_t c = 1; c < chunks.size(); ++c) {
      const table::Values& more = chunks[c].column(column.name).values;
      if (std::holds_alternative<std::vector<double>>(all.values))
        append<double>(all.values, more);
      else
        append<std::int64_t>(all.values, more);
    }
    out.add(all);
  }
  return out;
}

table::Attributes attributes_of(const RunSummary& s, const std::string& case_text) {
  table::Attributes a;
  a["repose_run"] = std::int64_t{1};
  a["steps"] = s.steps;
  a["time_step_s"] = s.time_step_s;
  a["particles"] = s.particles;
  a["mass_kg"] = s.mass_kg;
  a["wall_time_s"] = s.wall_time_s;
  a["largest_overlap_ratio"] = s.largest_overlap_ratio;
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
  s.particles = attribute<std::int64_t>(a, "particles", file);
  s.mass_kg = attribute<double>(a, "mass_kg", file);
  s.wall_time_s = attribute<double>(a, "wall_time_s", file);
  s.largest_overlap_ratio = attribute<double>(a, "largest_overlap_ratio", file);
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

RunWriter::RunWriter(fs::path directory, const Case& scene)
    : directory_(std::move(directory)),
      case_text_(case_text(scene)),
      region_columns_(region_columns(scene)) {
  make_directory(directory_);
  for (const char* part : {"run.h5", "snapshots", "series", "log.txt"})
    remove_tree(directory_ / part);
  make_directory(directory_ / "snapshots");
  make_directory(directory_ / "series");
  write_file_atomically(directory_ / "case.toml", case_text_);
}

void RunWriter::add_row(const SeriesRow& row) {
  rows_.push_back(row);
  if (rows_.size() >= kRowsOfAChunk) write_series_chunk();
}

void RunWriter::write_series_chunk() {
  if (rows_.empty()) return;
  table::write_table({directory_ / "series" / numbered("series", ++chunks_), "/table"},
                     table_of(rows_, region_columns_));
  rows_.clear();
}

void RunWriter::write_snapshot(const Snapshot& snapshot) {
  write_series_chunk();  // so that the series on disk is never older than the snapshots
  table::write_table({directory_ / "snapshots" / numbered("snapshot", ++snapshots_), "/table"},
                     table_of(snapshot));
}

void RunWriter::log(std::string_view line) {
  const fs::path path = directory_ / "log.txt";
  std::FILE* file = std::fopen(path.c_str(), "ab");
  if (file == nullptr) throw StorageError(path.string() + ": cannot be written");
  std::fwrite(line.data(), 1, line.size(), file);
  std::fputc('\n', file);
  if (std::fclose(file) != 0) throw StorageError(path.string() + ": cannot be written");
}

void RunWriter::finish(const RunSummary& summary) {
  write_series_chunk();
  std::vector<table::Table> chunks;
  for (int c = 1; c <= chunks_; ++c)
    chunks.push_back(table::read_table({directory_ / "series" / numbered("series", c), "/table"}));
  table::Attributes attributes = attributes_of(summary, case_text_);
  std::vector<std::pair<std::string, table::Table>> groups;
  if (!chunks.empty()) groups.emplace_back("/series", joined(chunks));
  std::vector<double> times;
  std::vector<std::string> stages;
  for (int s = 1; s <= snapshots_; ++s) {
    groups.emplace_back(
        snapshot_group(static_cast<std::size_t>(s - 1)),
        table::read_table({directory_ / "snapshots" / numbered("snapshot", s), "/table"}));
    const table::Attributes& of_snapshot = groups.back().second.attributes;
    times.push_back(std::get<double>(of_snapshot.at("time_s")));
    stages.push_back(std::get<std::string>(of_snapshot.at("stage")));
  }
  attributes["snapshot_times_s"] = times;
  attributes["snapshot_stages"] = stages;
  table::write_tables(directory_ / "run.h5", groups, attributes);
  remove_tree(directory_ / "series");
  remove_tree(directory_ / "snapshots");
}

Snapshot Run::snapshot(std::size_t i) const {
  if (i >= infos_.size())
    throw InputError(file_.string() + ": snapshot " + std::to_string(i + 1) +
                     " does not exist; the run has " + std::to_string(infos_.size()));
  return snapshot_of(table::read_table({file_, snapshot_group(i)}), file_);
}

Snapshot Run::end_of(const std::string& stage) const {
  for (std::size_t i = infos_.size(); i-- > 0;)
    if (infos_[i].stage == stage) return snapshot(i);
  std::vector<std::string> names;
  for (const StageEnd& end : summary_.stages) names.push_back(end.name);
  throw InputError(file_.string() + ": no snapshot of stage \"" + stage + "\"; the run has " +
                   listed(names));
}

Run read_run(const fs::path& path) {
  const bool is_folder = fs::is_directory(path);
  const fs::path file = is_folder ? path / "run.h5" : path;
  if (!fs::exists(file)) {
    const bool has_parts = is_folder && fs::exists(path / "case.toml");
    throw StorageError(has_parts ? path.string() +
                                       ": this run did not finish, it has no run.h5; see "
                                       "its log.txt and start it again"
                                 : path.string() +
                                       ": there is no run here; give the folder of a run or "
                                       "its run.h5");
  }
  const table::Attributes attributes = table::read_attributes({file, "/"});
  if (!attributes.contains("repose_run"))
    throw StorageError(file.string() + ": is not a run of repose");
  Run run;
  run.file_ = file;
  run.summary_ = summary_of(attributes, file);
  run.scene_ = parse_case(attribute<std::string>(attributes, "case", file), file.string());
  run.series_ = table::read_table({file, "/series"});
  const auto times = attribute<std::vector<double>>(attributes, "snapshot_times_s", file);
  const auto stages = attribute<std::vector<std::string>>(attributes, "snapshot_stages", file);
  for (std::size_t i = 0; i < times.size(); ++i) run.infos_.push_back({times[i], stages.at(i)});
  return run;
}

}  // namespace repose::scene
