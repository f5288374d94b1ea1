// Finished runs by the content of their inputs, for one study or many.
//
// STORE/runs/KEY/{case.toml, engine.log, output/, outcome.json}, one folder a run. outcome.json is
// written last and atomically: a folder without it is a run that has not finished.
// STORE/index.jsonl repeats each outcome.json on a line, so that ten thousand are read in one go;
// whatever it lacks is taken from the folders (docs/decisions/0011).
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <vector>

#include "repose/dem_adapter/measurement.hpp"
#include "repose/dem_adapter/outcome.hpp"

namespace repose::dem_adapter {

/// One run as recorded in its outcome.json.
struct RunOutcome {
  std::string key;  ///< folder under runs/
  std::uint64_t seed = 0;
  Measurement measurement;
  std::string engine;
  std::string measured_by;  ///< what gave the KPIs; empty if the engine did not finish
  Resources resources;
  double exceeded_limit_s = 0.0;  ///< the time limit that ended it; 0: it ended by itself
  bool failed() const { return is_failure(measurement.outcome); }
};

/// Names a run: 16 hexadecimal digits that stand for the engine, with its version and build, and
/// the case, which holds parameters and seed.
std::string run_key(const std::string& engine, const std::string& case_text);

enum class StoreAccess { read, write };

/// Thread-safe; several processes may use one store at the same time.
class RunStore {
 public:
  /// Reads the index and looks for runs that it lacks. Throws StorageError if the directory cannot
  /// be made (write) or is not there (read).
  RunStore(std::filesystem::path directory, StoreAccess access);
  ~RunStore();
  RunStore(const RunStore&) = delete;
  RunStore& operator=(const RunStore&) = delete;

  const std::filesystem::path& directory() const { return directory_; }
  std::filesystem::path folder(const std::string& key) const { return directory_ / "runs" / key; }

  /// A finished run, by whichever process. Throws StorageError if its outcome.json is damaged.
  std::optional<RunOutcome> find(const std::string& key) const;
  /// The same from the run's folder: what another process may have recorded or forgotten since.
  std::optional<RunOutcome> find_in_folder(const std::string& key) const;
  /// Writes outcome.json, then the index. Throws StorageError; the run is then as unfinished.
  void record(const RunOutcome& outcome) const;
  /// Makes the run unfinished; its other files stay.
  void forget(const std::string& key) const;

  std::size_t size() const;
  std::vector<std::string> keys() const;  ///< of finished runs, sorted
  /// Folders of runs without outcome: under way, or stopped.
  std::vector<std::string> unfinished() const;
  /// Rewrites the index without what was superseded.
  void compact_index() const;

 private:
  struct Place {
    std::int64_t offset = -1;  ///< in the index; -1: only in its folder
    std::int64_t length = 0;
  };
  void open_index() const;
  void read_index() const;
  void look_into_folders();
  void append(const std::string& key, const std::string& line) const;
  std::optional<RunOutcome> read_folder(const std::string& key) const;
  bool is_current_index() const;

  std::filesystem::path directory_;
  StoreAccess access_;
  mutable int index_ = -1;
  mutable std::mutex mutex_;
  mutable std::map<std::string, Place> places_;
};

/// A run's folder while somebody works in it, among threads and processes; given back at the end,
/// also that of the process.
class RunClaim {
 public:
  /// Waits for the folder, which is made; nothing if `given_up` becomes true before.
  static std::optional<RunClaim> take(const std::filesystem::path& folder,
                                      const std::function<bool()>& given_up);
  /// Nothing if somebody works in the folder.
  static std::optional<RunClaim> try_take(const std::filesystem::path& folder) {
    return take(folder, [] { return true; });
  }
  /// Whether somebody works in the folder.
  static bool is_taken(const std::filesystem::path& folder);
  RunClaim(RunClaim&& other) noexcept;
  RunClaim& operator=(RunClaim&&) = delete;
  ~RunClaim();

 private:
  explicit RunClaim(int lock) : lock_(lock) {}
  int lock_;
};

}  // namespace repose::dem_adapter
