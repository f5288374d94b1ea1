#include "readers.hpp"

#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <string>

#include "repose/base/error.hpp"
#include "repose/table/io.hpp"
#include "repose/table/reader.hpp"

namespace repose::fuzz {
namespace {

using table::Column;
using table::Missing;
using table::Table;
using table::Values;

void require(bool condition, const char* what) {
  if (condition) return;
  std::fprintf(stderr, "not true: %s\n", what);
  std::abort();
}

/// Equal values; the sign and payload of NaN aside.
bool is_same(const Values& a, const Values& b) {
  const auto* x = std::get_if<std::vector<double>>(&a);
  const auto* y = std::get_if<std::vector<double>>(&b);
  if (x == nullptr || y == nullptr) return a == b;
  return std::equal(x->begin(), x->end(), y->begin(), y->end(), [](double u, double v) {
    return std::isnan(u) ? std::isnan(v) : u == v && std::signbit(u) == std::signbit(v);
  });
}

bool is_same(const Table& a, const Table& b) {
  return std::equal(a.columns().begin(), a.columns().end(), b.columns().begin(), b.columns().end(),
                    [](const Column& x, const Column& y) {
                      return x.name == y.name && x.unit == y.unit && is_same(x.values, y.values);
                    });
}

bool holds_only_texts(const Table& table) {
  return std::all_of(table.columns().begin(), table.columns().end(), [](const Column& column) {
    return std::holds_alternative<std::vector<std::string>>(column.values);
  });
}

/// Bytes as a file of this process; HDF5 wants a path that it can resolve.
class BytesFile {
 public:
  explicit BytesFile(std::string_view bytes)
      : path_(std::filesystem::temp_directory_path() /
              ("repose_fuzz_" + std::to_string(::getpid()) + ".h5")) {
    std::ofstream out(path_, std::ios::binary);
    out.write(bytes.data(), static_cast<std::streamsize>(bytes.size()));
    out.close();
    require(static_cast<bool>(out), "a file can be written");
  }
  ~BytesFile() { std::filesystem::remove(path_); }
  BytesFile(const BytesFile&) = delete;
  BytesFile& operator=(const BytesFile&) = delete;
  const std::filesystem::path& path() const { return path_; }

 private:
  std::filesystem::path path_;
};

void read_in_blocks(const table::Location& location, const Table& whole) {
  const table::TableReader reader(location, Missing::allow);
  require(reader.rows() == whole.rows(), "a reader counts the rows that the table has");
  for (const Column& column : whole.columns()) {
    const std::size_t half = whole.rows() / 2;
    const Values first = reader.values(column.name, 0, half);
    const Values second = reader.values(column.name, half, whole.rows() - half);
    require(table::length(first) == half && table::length(second) == whole.rows() - half &&
                first.index() == column.values.index(),
            "blocks have the length and the type of the column");
  }
}

}  // namespace

int check_csv(std::string_view bytes) {
  Table parsed;
  try {
    parsed = table::parse_csv(bytes, "input", Missing::allow);
  } catch (const InputError&) {
    return 0;
  }
  const std::string text = table::csv_text(parsed);
  // Of texts that must all be quoted some may come back as numbers.
  require(
      holds_only_texts(parsed) || is_same(table::parse_csv(text, "output", Missing::allow), parsed),
      "CSV that we wrote is the table that it was written from");
  return 1;
}

int check_hdf5(std::string_view bytes) {
  const BytesFile file(bytes);
  std::vector<std::string> paths;
  try {
    paths = table::list_tables(file.path());
  } catch (const Error&) {
  }
  paths.emplace_back();  // the only table, if any
  int tables = 0;
  for (const std::string& path : paths) {
    const table::Location location{file.path(), path};
    try {
      const Table whole = table::read_table(location, Missing::allow);
      read_in_blocks(location, whole);
      table::read_attributes({file.path(), ""});
      ++tables;
    } catch (const Error&) {
    }
  }
  return tables;
}

}  // namespace repose::fuzz
