// Datasets: the columns of tables, and where they lie in datasets that hold several.
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <utility>

#include "hdf5_types.hpp"
#include "repose/base/error.hpp"

namespace repose::table::hdf5 {
namespace {

/// Columns above this many bytes are compressed if that gains anything.
constexpr std::size_t kCompressAboveBytes = 64 * 1024;
/// Values in a chunk: 512 kB, half of HDF5's chunk cache.
constexpr hsize_t kChunkRows = 64 * 1024;

/// "FILE:/runs, member mass_kg".
std::string where_of(const Object& dataset, const Part& part) {
  return part.member.empty() ? dataset.where
                             : fmt::format("{}, member \"{}\"", dataset.where, part.member);
}

std::string cannot_read(const std::string& where) {
  return fmt::format("cannot read {}", where);
}

/// The type of a member, or of the elements of one that is an array; the type itself otherwise.
struct ElementType {
  Handle type;
  std::vector<hsize_t> array;  ///< extents of a member that is an array
  std::size_t elements() const {
    std::size_t n = 1;
    for (const hsize_t extent : array) n *= extent;
    return n;
  }
};

ElementType element_type(hid_t type, const std::string& where) {
  const std::string what = cannot_read(where);
  if (H5Tget_class(type) != H5T_ARRAY) return {Handle(checked(H5Tcopy(type), what), H5Tclose), {}};
  std::vector<hsize_t> array(static_cast<std::size_t>(checked(H5Tget_array_ndims(type), what)));
  checked(H5Tget_array_dims2(type, array.data()), what);
  return {Handle(checked(H5Tget_super(type), what), H5Tclose), array};
}

ElementType type_of(const Object& dataset, const Part& part) {
  const std::string where = where_of(dataset, part);
  const std::string what = cannot_read(where);
  Handle type(checked(H5Dget_type(dataset.id()), what), H5Tclose);
  if (part.member.empty()) return {std::move(type), {}};
  const int index = checked(H5Tget_member_index(type.get(), part.member.c_str()), what);
  const Handle member(checked(H5Tget_member_type(type.get(), static_cast<unsigned>(index)), what),
                      H5Tclose);
  return element_type(member.get(), where);
}

/// Bytes of the dataset that the file holds; nothing if they lie elsewhere.
std::optional<double> stored_bytes(const Object& dataset, const std::string& what) {
  const Handle creation(checked(H5Dget_create_plist(dataset.id()), what), H5Pclose);
  const H5D_layout_t layout = H5Pget_layout(creation.get());
  if (layout == H5D_VIRTUAL || H5Pget_external_count(creation.get()) > 0) return std::nullopt;
  const Handle file(checked(H5Iget_file_id(dataset.id()), what), H5Fclose);
  hsize_t file_bytes = 0;
  checked(H5Fget_filesize(file.get(), &file_bytes), what);
  return static_cast<double>(std::min(file_bytes, H5Dget_storage_size(dataset.id())));
}

/// A damaged size would have us ask for all memory there is. Deflate makes at most 1032 bytes of
/// one [zlib, "Maximum Compression Factor"].
void refuse_implausible_size(const Object& dataset, const std::string& what) {
  constexpr double kHarmless = 64e6, kMostCompressed = 1032.0;
  const Handle type(checked(H5Dget_type(dataset.id()), what), H5Tclose);
  const Handle space(checked(H5Dget_space(dataset.id()), what), H5Sclose);
  const auto values = static_cast<double>(checked(H5Sget_simple_extent_npoints(space.get()), what));
  const double bytes = values * static_cast<double>(H5Tget_size(type.get()));
  if (bytes <= kHarmless) return;
  const std::optional<double> stored = stored_bytes(dataset, what);
  if (!stored || bytes <= kMostCompressed * *stored) return;
  throw StorageError(fmt::format(
      "{}: it says that it has {:.0f} values, but only {:.0f} bytes are stored; it is damaged or "
      "was never filled",
      what, values, *stored));
}

/// The file's side of the rows.
Handle selection(const Object& dataset, const Part& part, const RowRange& rows) {
  const std::string what = cannot_read(dataset.where);
  Handle space(checked(H5Dget_space(dataset.id()), what), H5Sclose);
  const int rank = checked(H5Sget_simple_extent_ndims(space.get()), what);
  REPOSE_ASSERT(rank == 1 || rank == 2, fmt::format("{} has rank {}", dataset.where, rank));
  std::array<hsize_t, 2> first{part.column, part.column};
  std::array<hsize_t, 2> count{1, 1};
  const auto axis = static_cast<std::size_t>(rank == 1 ? 0 : part.row_axis);
  first[axis] = rows.first;
  count[axis] = rows.count;
  checked(H5Sselect_hyperslab(space.get(), H5S_SELECT_SET, first.data(), nullptr, count.data(),
                              nullptr),
          what);
  return space;
}

/// Reads rows of one dataset, or of one member of it, into contiguous memory.
struct RowFetch {
  const Object& dataset;
  const Part& part;
  const ElementType& element;
  hsize_t count;
  const Handle& file_space;

  void operator()(hid_t memory_type, void* data) const {
    if (part.member.empty()) return read(memory_type, data);
    const std::string what = cannot_read(where_of(dataset, part));
    const std::size_t size = H5Tget_size(memory_type);
    const std::size_t elements = element.elements();
    const Handle inner(
        checked(element.array.empty()
                    ? H5Tcopy(memory_type)
                    : H5Tarray_create2(memory_type, static_cast<unsigned>(element.array.size()),
                                       element.array.data()),
                what),
        H5Tclose);
    const Handle record(checked(H5Tcreate(H5T_COMPOUND, size * elements), what), H5Tclose);
    checked(H5Tinsert(record.get(), part.member.c_str(), 0, inner.get()), what);
    if (elements == 1) return read(record.get(), data);
    std::vector<char> all(count * size * elements);
    read(record.get(), all.data());
    for (hsize_t row = 0; row < count; ++row)
      std::memcpy(static_cast<char*>(data) + row * size,
                  all.data() + (row * elements + part.element) * size, size);
  }

 private:
  void read(hid_t memory_type, void* data) const {
    const std::string what = cannot_read(where_of(dataset, part));
    const Handle memory_space(checked(H5Screate_simple(1, &count, nullptr), what), H5Sclose);
    checked(
        H5Dread(dataset.id(), memory_type, memory_space.get(), file_space.get(), H5P_DEFAULT, data),
        fmt::format("{}: it is damaged", what));
  }
};

std::string unknown_type(hid_t type) {
  return H5Tget_class(type) == H5T_REFERENCE
             ? "holds references to other data, as a MATLAB cell array or array of structs does; "
               "store an array of numbers for each column"
             : "has a type that is neither number nor text; a column of a table holds one of these";
}

std::string cannot_write(const std::string& where) {
  return fmt::format("cannot write {}", where);
}

/// Entropy of the byte planes of (a sample of) 8-byte values as a fraction of their size: what
/// shuffle and deflate can reach on values that do not repeat in sequence. [Shannon1948,
/// equation 1.4]
double shuffled_entropy(const unsigned char* bytes, std::size_t rows) {
  constexpr std::size_t kSample = 8192;
  const std::size_t stride = std::max<std::size_t>(1, rows / kSample);
  const std::size_t sampled = (rows + stride - 1) / stride;
  double bits = 0.0;
  for (std::size_t plane = 0; plane < 8; ++plane) {
    std::array<std::size_t, 256> histogram{};
    for (std::size_t row = 0; row < rows; row += stride) ++histogram[bytes[8 * row + plane]];
    for (const std::size_t n : histogram)
      if (n > 0)
        bits -= static_cast<double>(n) *
                std::log2(static_cast<double>(n) / static_cast<double>(sampled));
  }
  return bits / (64.0 * static_cast<double>(sampled));
}

/// Values as HDF5 takes them: numbers as they lie in memory, texts as pointers.
struct Cells {
  Handle file_type;
  Handle memory_type;
  const void* data;
  std::size_t rows;
  bool are_numbers;
  std::vector<const char*> pointers;
};

Cells cells_of(const Values& values, const std::string& where) {
  const std::string what = cannot_write(where);
  const auto copy = [&](hid_t type) { return Handle(checked(H5Tcopy(type), what), H5Tclose); };
  if (const auto* doubles = std::get_if<std::vector<double>>(&values))
    return {
        copy(H5T_IEEE_F64LE), copy(H5T_NATIVE_DOUBLE), doubles->data(), doubles->size(), true, {}};
  if (const auto* integers = std::get_if<std::vector<std::int64_t>>(&values))
    return {
        copy(H5T_STD_I64LE), copy(H5T_NATIVE_INT64), integers->data(), integers->size(), true, {}};
  std::vector<const char*> pointers = pointers_to(std::get<std::vector<std::string>>(values));
  const void* const data = pointers.data();
  const std::size_t rows = pointers.size();
  return {text_type(where), text_type(where), data, rows, false, std::move(pointers)};
}

/// Whether shuffle and deflate make numbers smaller: random mantissas take seconds and gain a
/// tenth.
bool is_compressible(const Cells& cells) {
  constexpr double kWorthwhile = 0.8;
  return cells.are_numbers && cells.rows * 8 > kCompressAboveBytes &&
         shuffled_entropy(static_cast<const unsigned char*>(cells.data), cells.rows) <= kWorthwhile;
}

Object create_dataset(const Object& group, const std::string& name, const Cells& cells,
                      const Handle& space, const Handle& creation, hid_t access = H5P_DEFAULT) {
  const std::string where = fmt::format("{}/{}", group.where, name);
  const hid_t id = H5Dcreate2(group.id(), name.c_str(), cells.file_type.get(), space.get(),
                              H5P_DEFAULT, creation.get(), access);
  return {Handle(checked(id, cannot_write(where)), H5Dclose), where};
}

/// How a dataset is stored: in one piece, or in chunks if it grows or is compressed.
Handle storage(const Cells& cells, std::optional<hsize_t> chunk, const std::string& what) {
  Handle creation(checked(H5Pcreate(H5P_DATASET_CREATE), what), H5Pclose);
  const bool compress = is_compressible(cells);
  if (!chunk && compress) chunk = std::min<hsize_t>(cells.rows, kChunkRows);
  if (chunk) checked(H5Pset_chunk(creation.get(), 1, &*chunk), what);
  if (!compress) return creation;
  checked(H5Pset_shuffle(creation.get()), what);
  checked(H5Pset_deflate(creation.get(), 1), what);
  return creation;
}

}  // namespace

Values read_values(const Object& dataset, const Part& part, const RowRange& rows) {
  const std::string where = where_of(dataset, part);
  const ElementType element = type_of(dataset, part);
  refuse_implausible_size(dataset, cannot_read(where));
  if (element.elements() != 1 && H5Tis_variable_str(element.type.get()) > 0)
    throw InputError(
        fmt::format("{} holds arrays of texts of variable length; store one text a row", where));
  const Handle file_space = selection(dataset, part, rows);
  const Source source{
      .type = element.type.get(),
      .count = static_cast<std::size_t>(rows.count),
      .where = where,
      .fetch = RowFetch{dataset, part, element, rows.count, file_space},
  };
  std::optional<Values> values = read_known(source);
  if (!values) throw InputError(fmt::format("{} {}", where, unknown_type(element.type.get())));
  return std::move(*values);
}

std::vector<Member> members(const Object& dataset) {
  const std::string what = cannot_read(dataset.where);
  const Handle type(checked(H5Dget_type(dataset.id()), what), H5Tclose);
  if (H5Tget_class(type.get()) != H5T_COMPOUND) return {};
  std::vector<Member> result;
  const auto count = static_cast<unsigned>(checked(H5Tget_nmembers(type.get()), what));
  for (unsigned i = 0; i < count; ++i) {
    char* const name = H5Tget_member_name(type.get(), i);
    if (name == nullptr) fail(what);
    result.push_back({name, 1});
    H5free_memory(name);
    const Handle member(checked(H5Tget_member_type(type.get(), i), what), H5Tclose);
    result.back().elements = element_type(member.get(), dataset.where).elements();
  }
  return result;
}

bool holds_numbers(const Object& dataset) {
  const Handle type(checked(H5Dget_type(dataset.id()), cannot_read(dataset.where)), H5Tclose);
  const H5T_class_t kind = H5Tget_class(type.get());
  return kind == H5T_FLOAT || kind == H5T_INTEGER || kind == H5T_ENUM || kind == H5T_BITFIELD;
}

hsize_t chunk_rows(const Object& dataset, const Part& part) {
  const std::string what = cannot_read(dataset.where);
  const Handle creation(checked(H5Dget_create_plist(dataset.id()), what), H5Pclose);
  if (H5Pget_layout(creation.get()) != H5D_CHUNKED) return 1;
  std::array<hsize_t, 2> chunk{1, 1};
  const int rank = checked(H5Pget_chunk(creation.get(), 2, chunk.data()), what);
  return chunk[static_cast<std::size_t>(rank == 1 ? 0 : part.row_axis)];
}

Object write_values(const Object& group, const std::string& name, const Values& values) {
  const std::string where = fmt::format("{}/{}", group.where, name);
  const std::string what = cannot_write(where);
  const Cells cells = cells_of(values, where);
  const hsize_t extent = cells.rows;
  const Handle space(checked(H5Screate_simple(1, &extent, nullptr), what), H5Sclose);
  Object dataset = create_dataset(group, name, cells, space, storage(cells, std::nullopt, what));
  checked(
      H5Dwrite(dataset.id(), cells.memory_type.get(), H5S_ALL, H5S_ALL, H5P_DEFAULT, cells.data),
      what);
  return dataset;
}

Object create_growing(const Object& group, const std::string& name, const Values& sample,
                      hsize_t chunk_rows) {
  const std::string where = fmt::format("{}/{}", group.where, name);
  const std::string what = cannot_write(where);
  const Cells cells = cells_of(sample, where);
  constexpr hsize_t kNone = 0, kUnlimited = H5S_UNLIMITED;
  const Handle space(checked(H5Screate_simple(1, &kNone, &kUnlimited), what), H5Sclose);
  // A chunk is written once: HDF5 need not keep more of each column.
  const Handle access(checked(H5Pcreate(H5P_DATASET_ACCESS), what), H5Pclose);
  const std::size_t chunk_bytes = chunk_rows * H5Tget_size(cells.file_type.get());
  checked(H5Pset_chunk_cache(access.get(), 11, chunk_bytes, 1.0), what);
  return create_dataset(group, name, cells, space, storage(cells, chunk_rows, what), access.get());
}

void append_values(const Object& dataset, hsize_t rows, const Values& values) {
  const std::string what = cannot_write(dataset.where);
  const Cells cells = cells_of(values, dataset.where);
  const hsize_t count = cells.rows;
  if (count == 0) return;
  const hsize_t extent = rows + count;
  checked(H5Dset_extent(dataset.id(), &extent), what);
  const Handle memory_space(checked(H5Screate_simple(1, &count, nullptr), what), H5Sclose);
  const Handle file_space(checked(H5Dget_space(dataset.id()), what), H5Sclose);
  checked(H5Sselect_hyperslab(file_space.get(), H5S_SELECT_SET, &rows, nullptr, &count, nullptr),
          what);
  checked(H5Dwrite(dataset.id(), cells.memory_type.get(), memory_space.get(), file_space.get(),
                   H5P_DEFAULT, cells.data),
          what);
}

}  // namespace repose::table::hdf5
