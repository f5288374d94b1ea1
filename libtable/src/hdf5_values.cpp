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

Handle dataset_creation(const void* data, std::size_t rows, const std::string& where) {
  const std::string what = cannot_write(where);
  Handle creation(checked(H5Pcreate(H5P_DATASET_CREATE), what), H5Pclose);
  // Random mantissas take seconds to deflate and gain a tenth.
  constexpr double kWorthwhile = 0.8;
  if (data == nullptr || rows * 8 <= kCompressAboveBytes ||
      shuffled_entropy(static_cast<const unsigned char*>(data), rows) > kWorthwhile)
    return creation;
  const hsize_t chunk = std::min<hsize_t>(rows, kChunkRows);
  checked(H5Pset_chunk(creation.get(), 1, &chunk), what);
  checked(H5Pset_shuffle(creation.get()), what);
  checked(H5Pset_deflate(creation.get(), 1), what);
  return creation;
}

Object create_dataset(const Object& group, const std::string& name, hid_t file_type,
                      hid_t memory_type, const void* data, std::size_t rows,
                      const Handle& creation) {
  const std::string where = fmt::format("{}/{}", group.where, name);
  const std::string what = cannot_write(where);
  const hsize_t extent = rows;
  const Handle space(checked(H5Screate_simple(1, &extent, nullptr), what), H5Sclose);
  const hid_t id = H5Dcreate2(group.id(), name.c_str(), file_type, space.get(), H5P_DEFAULT,
                              creation.get(), H5P_DEFAULT);
  Object dataset{Handle(checked(id, what), H5Dclose), where};
  checked(H5Dwrite(dataset.id(), memory_type, H5S_ALL, H5S_ALL, H5P_DEFAULT, data), what);
  return dataset;
}

}  // namespace

Values read_values(const Object& dataset, const Part& part, const RowRange& rows) {
  const std::string where = where_of(dataset, part);
  const ElementType element = type_of(dataset, part);
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
  const std::size_t rows = length(values);
  if (const auto* doubles = std::get_if<std::vector<double>>(&values))
    return create_dataset(group, name, H5T_IEEE_F64LE, H5T_NATIVE_DOUBLE, doubles->data(), rows,
                          dataset_creation(doubles->data(), rows, where));
  if (const auto* integers = std::get_if<std::vector<std::int64_t>>(&values))
    return create_dataset(group, name, H5T_STD_I64LE, H5T_NATIVE_INT64, integers->data(), rows,
                          dataset_creation(integers->data(), rows, where));
  const std::vector<const char*> pointers = pointers_to(std::get<std::vector<std::string>>(values));
  const Handle type = text_type(where);
  return create_dataset(group, name, type.get(), type.get(), pointers.data(), rows,
                        dataset_creation(nullptr, rows, where));
}

}  // namespace repose::table::hdf5
