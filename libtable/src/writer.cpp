#include "repose/table/writer.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstring>
#include <fstream>
#include <optional>
#include <utility>

#include "checks.hpp"
#include "repose/base/error.hpp"
#include "repose/base/file.hpp"
#include "write.hpp"
#include "writer_lock.hpp"

namespace repose::table {
namespace {

/// Rows of a piece: a chunk of each column, of 512 kB as write_table() has it, 64 MB together.
std::size_t piece_rows(std::size_t columns) {
  constexpr std::size_t kMost = 64 * 1024, kLeast = 1024, kBytes = std::size_t{64} << 20;
  return std::clamp(kBytes / (8 * std::max<std::size_t>(1, columns)), kLeast, kMost);
}

const char* type_of(const Column& column) {
  constexpr std::array<const char*, 3> kNames = {"decimal numbers", "integers", "text"};
  return kNames[column.values.index()];
}

void append_rows(Values& to, const Values& from, std::size_t first, std::size_t count) {
  std::visit(
      [&](auto& values) {
        const auto& all = std::get<std::decay_t<decltype(values)>>(from);
        const auto start = all.begin() + static_cast<std::ptrdiff_t>(first);
        values.insert(values.end(), start, start + static_cast<std::ptrdiff_t>(count));
      },
      to);
}

/// A file of rows that is not yet in its place.
class Rows {
 public:
  Rows() = default;
  Rows(const Rows&) = delete;
  Rows& operator=(const Rows&) = delete;
  virtual ~Rows() = default;
  virtual void write(const Table& piece) = 0;
  /// Writes the last piece and closes the file.
  virtual void finish(const Table& last) = 0;
};

class CsvRows : public Rows {
 public:
  CsvRows(const std::filesystem::path& path, const Location& location, const Table& header)
      : file_(location.file), stream_(path, std::ios::binary) {
    refuse_no_columns(header, file_);
    put(csv_header(header));
  }
  void write(const Table& piece) override { put(csv_rows(piece)); }
  void finish(const Table& last) override {
    put(csv_rows(last));
    stream_.close();
    require();
  }

 private:
  void put(const std::string& text) {
    stream_.write(text.data(), static_cast<std::streamsize>(text.size()));
    require();
  }
  void require() const {
    if (!stream_)
      throw StorageError(fmt::format("cannot write {}: {}", file_.string(), std::strerror(errno)));
  }
  std::filesystem::path file_;
  std::ofstream stream_;
};

class Hdf5Rows : public Rows {
 public:
  Hdf5Rows(const std::filesystem::path& path, const Location& location, Table header)
      : group_path_(chosen_group(location)), header_(std::move(header)) {
    check_storable(header_, location_text(location));
    const hdf5::Session session;
    file_.emplace(hdf5::create_file(path, location.file.string()));
  }
  ~Hdf5Rows() override {
    const hdf5::Session session;
    datasets_.clear();
    group_.reset();
    file_.reset();
  }

  void write(const Table& piece) override {
    const hdf5::Session session;
    append(piece);
  }

  void finish(const Table& last) override {
    const hdf5::Session session;
    if (!group_) {
      write_group(*file_, group_path_, last);
    } else {
      append(last);
      write_description(*group_, header_);
    }
    datasets_.clear();
    group_.reset();
    hdf5::Object file = std::move(*file_);
    file_.reset();
    hdf5::finish_file(std::move(file));
  }

 private:
  void append(const Table& piece) {
    if (!group_) create(piece);
    for (std::size_t j = 0; j < datasets_.size(); ++j)
      hdf5::append_values(datasets_[j], rows_, piece.columns()[j].values);
    rows_ += piece.rows();
  }

  void create(const Table& piece) {
    group_.emplace(hdf5::create_group(*file_, group_path_));
    for (const Column& column : piece.columns()) {
      datasets_.push_back(hdf5::create_growing(*group_, column.name, column.values, piece.rows()));
      write_description(datasets_.back(), column);
    }
  }

  std::string group_path_;
  Table header_;
  hsize_t rows_ = 0;
  std::optional<hdf5::Object> file_, group_;
  std::vector<hdf5::Object> datasets_;  // of each column
};

}  // namespace

struct TableWriter::State {
  enum class Stage { open, failed, finished };

  Location location;
  std::string where;
  std::optional<WriterLock> lock;
  TemporaryFile temporary;
  std::vector<Column> pending;  // rows not yet written, described as in the header
  Attributes attributes;
  std::unique_ptr<Rows> file;
  std::size_t rows = 0;
  Stage stage = Stage::open;

  State(const Location& place, const Table& header)
      : location(place),
        where(location_text(place)),
        lock(std::in_place, place.file),
        temporary(place.file),
        pending(header.columns()),
        attributes(header.attributes) {
    if (header.rows() > 0)
      throw InputError(fmt::format("the header of {} has {} rows; give it none and append them",
                                   where, header.rows()));
    if (is_csv(place.file))
      file = std::make_unique<CsvRows>(temporary.path(), place, header);
    else
      file = std::make_unique<Hdf5Rows>(temporary.path(), place, header);
  }

  std::size_t pending_rows() const { return pending.empty() ? 0 : length(pending[0].values); }

  /// The block's columns in the header's order. Throws InputError for any that cannot be appended.
  std::vector<const Column*> matching(const Table& block) const {
    std::vector<const Column*> columns;
    for (const Column& wanted : pending) {
      const Column& found = block.column(wanted.name);
      if (found.unit != wanted.unit)
        throw InputError(fmt::format("column \"{}\" of {} has the unit {}; that of a block is {}",
                                     wanted.name, where, wanted.unit, found.unit));
      if (found.values.index() != wanted.values.index())
        throw InputError(fmt::format("column \"{}\" of {} holds {}; that of a block holds {}",
                                     wanted.name, where, type_of(wanted), type_of(found)));
      refuse_values(found.values, found.name, rows, where, Missing::allow);
      if (!is_csv(location.file)) refuse_nul(found.values, where);
      columns.push_back(&found);
    }
    for (const Column& column : block.columns())
      if (std::none_of(pending.begin(), pending.end(),
                       [&](const Column& known) { return known.name == column.name; }))
        throw InputError(
            fmt::format("{} has no column \"{}\", which a block has", where, column.name));
    return columns;
  }

  /// The pending rows as a table; none are pending then.
  Table taken() {
    Table piece;
    piece.attributes = attributes;
    for (Column& column : pending) {
      Values none = std::visit(
          [](auto& values) -> Values { return std::decay_t<decltype(values)>(); }, column.values);
      piece.add({column.name, column.unit, column.role, column.range,
                 std::exchange(column.values, std::move(none))});
    }
    return piece;
  }

  void append(const Table& block) {
    const std::vector<const Column*> columns = matching(block);
    const std::size_t size = piece_rows(pending.size());
    for (std::size_t first = 0; first < block.rows();) {
      const std::size_t count = std::min(size - pending_rows(), block.rows() - first);
      for (std::size_t j = 0; j < pending.size(); ++j)
        append_rows(pending[j].values, columns[j]->values, first, count);
      first += count;
      if (pending_rows() == size) file->write(taken());
    }
    rows += block.rows();
  }

  void require_open() const {
    REPOSE_ASSERT(stage != Stage::finished, fmt::format("{} is finished", where));
    if (stage == Stage::failed)
      throw StorageError(fmt::format("cannot write {}: an earlier part of it failed", where));
  }
};

TableWriter::TableWriter(const Location& location, const Table& header)
    : state_(std::make_unique<State>(location, header)) {}
TableWriter::TableWriter(TableWriter&&) noexcept = default;
TableWriter& TableWriter::operator=(TableWriter&&) noexcept = default;
TableWriter::~TableWriter() = default;

void TableWriter::append(const Table& block) {
  state_->require_open();
  try {
    state_->append(block);
  } catch (const StorageError&) {
    state_->stage = State::Stage::failed;
    throw;
  }
}

std::size_t TableWriter::rows() const {
  return state_->rows;
}

void TableWriter::finish() {
  state_->require_open();
  state_->stage = State::Stage::failed;
  state_->file->finish(state_->taken());
  commit_file(state_->temporary.path(), state_->location.file);
  state_->lock.reset();
  state_->stage = State::Stage::finished;
}

}  // namespace repose::table
