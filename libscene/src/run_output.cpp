#include "repose/scene/run_output.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cstdio>
#include <optional>
#include <utility>

#include "repose/base/error.hpp"
#include "repose/base/file.hpp"
#include "repose/base/text.hpp"
#include "repose/scene/vtp.hpp"
#include "repose/table/io.hpp"
#include "row_table.hpp"
#include "run_parts.hpp"
#include "run_tables.hpp"

namespace repose::scene {
namespace {

namespace fs = std::filesystem;

std::string snapshot_group(std::size_t i) {
  return fmt::format("/snapshots/{:06}", i + 1);
}

}  // namespace

struct RunWriter::State {
  fs::path directory;
  std::string case_text;
  RowTable series, walls, contacts, energy;
  std::optional<VtpWriter> vtp{};
  int snapshots = 0;

  State(fs::path at, const Case& scene)
      : directory(std::move(at)),
        case_text(scene::case_text(scene)),
        series(directory / "series", "series", series_heads(scene)),
        walls(directory / "series", "walls", wall_heads(scene)),
        contacts(directory / "series", "contacts", contact_heads(scene)),
        energy(directory / "series", "energy", energy_heads()) {}

  std::array<RowTable*, 4> tables() { return {&series, &walls, &contacts, &energy}; }
  fs::path snapshot_file(int number) const {
    return directory / "snapshots" / fmt::format("snapshot_{:06}.h5", number);
  }
};

fs::path checkpoint_file(const fs::path& run_dir) {
  return run_dir / "checkpoint.h5";
}

RunWriter::RunWriter(fs::path directory, const Case& scene)
    : state_(std::make_unique<State>(std::move(directory), scene)) {
  const fs::path& folder = state_->directory;
  make_directory(folder);
  for (const char* part : {"run.h5", "checkpoint.h5", "snapshots", "series", "vtp", "log.txt"})
    remove_tree(folder / part);
  remove_unfinished(folder);
  make_directory(folder / "snapshots");
  make_directory(folder / "series");
  write_file_atomically(folder / "case.toml", state_->case_text);
  if (scene.output.vtp) state_->vtp.emplace(folder / "vtp", scene);
}

RunWriter::RunWriter(fs::path directory, const Case& scene, const OutputPosition& position)
    : state_(std::make_unique<State>(std::move(directory), scene)) {
  const fs::path& folder = state_->directory;
  for (const fs::path& part : {folder, folder / "snapshots", folder / "series", folder / "vtp"})
    remove_unfinished(part);
  remove_part(folder / "run.h5");
  const auto tables = state_->tables();
  write_file_atomically(folder / "case.toml", state_->case_text);
  if (position.chunks.size() != tables.size())
    throw StorageError(folder.string() + ": the output of another version cannot go on");
  for (std::size_t t = 0; t < tables.size(); ++t)
    tables[t]->go_on_after(static_cast<int>(position.chunks[t]));
  std::vector<double> times_s;
  for (; state_->snapshots < position.snapshots; ++state_->snapshots) {
    const fs::path file = state_->snapshot_file(state_->snapshots + 1);
    require_part(file);
    times_s.push_back(attribute<double>(table::read_attributes({file, "/table"}), "time_s", file));
  }
  for (int s = state_->snapshots + 1; remove_part(state_->snapshot_file(s)); ++s) {
  }
  if (!scene.output.vtp) return;
  state_->vtp.emplace(folder / "vtp", scene);
  state_->vtp->go_on_after(times_s, position.poses);
}

RunWriter::~RunWriter() = default;
RunWriter::RunWriter(RunWriter&&) noexcept = default;
RunWriter& RunWriter::operator=(RunWriter&&) noexcept = default;

void RunWriter::add_row(const SeriesRow& row) {
  state_->series.add(values_of(row));
}
void RunWriter::add_row(const WallRow& row) {
  state_->walls.add(values_of(row));
}
void RunWriter::add_row(const ContactRow& row) {
  state_->contacts.add(values_of(row));
}
void RunWriter::add_row(const EnergyRow& row) {
  state_->energy.add(values_of(row));
}

void RunWriter::write_snapshot(const Snapshot& snapshot, const std::vector<WallPose>& poses) {
  // So that time series on disk are never older than the snapshots.
  for (RowTable* table : state_->tables()) table->flush();
  table::write_table({state_->snapshot_file(state_->snapshots + 1), "/table"}, table_of(snapshot));
  ++state_->snapshots;
  if (state_->vtp) state_->vtp->write(snapshot, poses);
}

OutputPosition RunWriter::position() {
  OutputPosition position{.snapshots = state_->snapshots};
  for (RowTable* table : state_->tables()) {
    table->flush();
    position.chunks.push_back(table->chunks());
  }
  if (state_->vtp) position.poses = state_->vtp->poses();
  return position;
}

void RunWriter::log(std::string_view line) {
  const fs::path path = state_->directory / "log.txt";
  std::FILE* file = std::fopen(path.c_str(), "ab");
  if (file == nullptr) throw StorageError(path.string() + ": cannot be written");
  std::fwrite(line.data(), 1, line.size(), file);
  std::fputc('\n', file);
  if (std::fclose(file) != 0) throw StorageError(path.string() + ": cannot be written");
}

void RunWriter::finish(const RunSummary& summary) {
  table::Attributes attributes = attributes_of(summary, state_->case_text);
  std::vector<std::pair<std::string, table::Table>> groups;
  for (RowTable* table : state_->tables())
    if (!table->is_empty()) groups.emplace_back("/" + table->name(), table->whole());
  std::vector<double> times;
  std::vector<std::string> stages;
  for (int s = 1; s <= state_->snapshots; ++s) {
    groups.emplace_back(snapshot_group(static_cast<std::size_t>(s - 1)),
                        table::read_table({state_->snapshot_file(s), "/table"}));
    const table::Attributes& of_snapshot = groups.back().second.attributes;
    times.push_back(std::get<double>(of_snapshot.at("time_s")));
    stages.push_back(std::get<std::string>(of_snapshot.at("stage")));
  }
  attributes["snapshot_times_s"] = times;
  attributes["snapshot_stages"] = stages;
  table::write_tables(state_->directory / "run.h5", groups, attributes);
  remove_part(checkpoint_file(state_->directory));  // while the parts are there that it needs
  remove_tree(state_->directory / "series");
  remove_tree(state_->directory / "snapshots");
}

namespace {

/// A table that not every run has.
table::Table table_if_recorded(const fs::path& file, const char* group, const char* reason) {
  const std::vector<std::string> present = table::list_tables(file);
  if (std::find(present.begin(), present.end(), group) == present.end())
    throw InputError(file.string() + ": has no table " + group + "; " + reason);
  return table::read_table({file, group});
}

}  // namespace

table::Table Run::walls() const {
  return table_if_recorded(file_, "/walls", "the case has no walls or its engine gave no forces");
}

table::Table Run::contacts() const {
  return table_if_recorded(file_, "/contacts", "its engine gave no contacts");
}

table::Table Run::energy() const {
  return table_if_recorded(file_, "/energy", "set output.energy = true in the case and run again");
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
