#include "row_table.hpp"

#include <fmt/format.h>

#include <stdexcept>
#include <utility>

#include "repose/table/io.hpp"
#include "run_parts.hpp"

namespace repose::scene {
namespace {

constexpr std::size_t kRowsOfAChunk = 4096;

table::Table table_of(const std::vector<ColumnHead>& heads,
                      const std::vector<std::vector<double>>& columns) {
  table::Table out;
  for (std::size_t c = 0; c < heads.size(); ++c) {
    table::Column column{.name = heads[c].name, .unit = heads[c].unit};
    if (heads[c].type == ColumnType::integer)
      column.values = std::vector<std::int64_t>(columns[c].begin(), columns[c].end());
    else
      column.values = columns[c];
    out.add(std::move(column));
  }
  return out;
}

}  // namespace

RowTable::RowTable(std::filesystem::path folder, std::string name, std::vector<ColumnHead> heads)
    : folder_(std::move(folder)),
      name_(std::move(name)),
      heads_(std::move(heads)),
      waiting_(heads_.size()) {}

std::filesystem::path RowTable::chunk_file(int number) const {
  return folder_ / fmt::format("{}_{:06}.h5", name_, number);
}

void RowTable::add(const std::vector<double>& row) {
  if (row.size() != heads_.size())
    throw std::logic_error(fmt::format("a row of the table {} has {} values for {} columns", name_,
                                       row.size(), heads_.size()));
  for (std::size_t c = 0; c < row.size(); ++c) waiting_[c].push_back(row[c]);
  if (waiting_.front().size() >= kRowsOfAChunk) flush();
}

void RowTable::flush() {
  if (waiting_.front().empty()) return;
  table::write_table({chunk_file(chunks_ + 1), "/table"}, table_of(heads_, waiting_));
  ++chunks_;
  for (std::vector<double>& column : waiting_) column.clear();
}

void RowTable::go_on_after(int chunks) {
  for (int chunk = 1; chunk <= chunks; ++chunk) require_part(chunk_file(chunk));
  for (int chunk = chunks + 1; remove_part(chunk_file(chunk)); ++chunk) {
  }
  chunks_ = chunks;
}

table::Table RowTable::whole() {
  std::vector<std::vector<double>> columns(heads_.size());
  const auto append = [&](std::size_t c, const std::vector<double>& more) {
    columns[c].insert(columns[c].end(), more.begin(), more.end());
  };
  for (int chunk = 1; chunk <= chunks_; ++chunk) {
    const table::Table part = table::read_table({chunk_file(chunk), "/table"});
    for (std::size_t c = 0; c < heads_.size(); ++c) append(c, part.numbers(heads_[c].name));
  }
  for (std::size_t c = 0; c < heads_.size(); ++c) append(c, waiting_[c]);
  return table_of(heads_, columns);
}

}  // namespace repose::scene
