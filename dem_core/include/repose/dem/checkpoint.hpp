// A simulation on disk: all that it needs to go on as if it had never stopped.
//
// An HDF5 file with the tables /spheres, /clumps, /clump_spheres, /contacts, /wall_contacts,
// /walls, /stages, /rains, by ascending id and so without trace of who wrote it, those of the run
// (see run_case.hpp), and attributes; docs/methods/dem.md lists them.
#pragma once

#include <filesystem>
#include <string>
#include <utility>
#include <vector>

#include "repose/scene/case.hpp"
#include "repose/table/table.hpp"

namespace repose::dem {

/// Made by Simulation::checkpoint(); whoever runs the simulation may add tables and attributes.
struct Checkpoint {
  std::string case_text;                                     ///< scene::case_text() of the case
  std::vector<std::pair<std::string, table::Table>> tables;  ///< by path, e.g. "/spheres"
  table::Attributes attributes;

  /// Throw StorageError if it is not there or has another type.
  const table::Table& table(const std::string& path) const;
  double number(const std::string& attribute) const;
  std::int64_t integer(const std::string& attribute) const;
  std::vector<double> numbers(const std::string& attribute, std::size_t count) const;
};

/// Writes atomically: until the last instant the file holds what it held before. Throws
/// StorageError.
void write_checkpoint(const std::filesystem::path& file, const Checkpoint& checkpoint);

/// Throws StorageError for a file that cannot be read, is damaged (its checksum covers every
/// byte) or has another version.
Checkpoint read_checkpoint(const std::filesystem::path& file);

/// Throws InputError if the case could not have come to this state, naming the section where it
/// differs from that of the checkpoint and what stands there. How often checkpoints are written may
/// differ, and all that belongs to stages that had not begun: see scene::beginning_of().
void require_same_beginning(const Checkpoint& checkpoint, const scene::Case& scene);

}  // namespace repose::dem
