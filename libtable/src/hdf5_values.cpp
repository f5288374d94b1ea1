// Values of datasets and attributes, between C++ and HDF5's types.
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <limits>
#include <new>
#include <stdexcept>
#include <utility>

#include "hdf5.hpp"
#include "repose/base/error.hpp"

namespace repose::table::hdf5 {
namespace {

/// Columns above this many bytes are compressed if that gains anything.
constexpr std::size_t kCompressAboveBytes = 64 * 1024;
/// Values in a chunk: 512 kB, half of HDF5's chunk cache.
constexpr hsize_t kChunkRows = 64 * 1024;

std::string cannot_read(const std::string& where) {
  return fmt::format("cannot read {}", where);
}
std::string cannot_write(const std::string& where) {
  return fmt::format("cannot write {}", where);
}

/// What reading and writing values has in common for datasets and attributes.
struct Source {
  hid_t type;
  hid_t space;
  std::size_t count;
  bool is_attribute;
  hid_t id;
  const std::string& where;

  void read(hid_t memory_type, void* data) const {
    if (count == 0) return;  // HDF5 refuses the null pointer of an empty vector
    checked(is_attribute ? H5Aread(id, memory_type, data)
                         : H5Dread(id, memory_type, H5S_ALL, H5S_ALL, H5P_DEFAULT, data),
            fmt::format("{}: it is damaged", cannot_read(where)));
  }
};

template <class T>
std::vector<T> sized(std::size_t count, const std::string& where) try {
  return std::vector<T>(count);
} catch (const std::bad_alloc&) {
  throw StorageError(
      fmt::format("{}: its {} values do not fit into memory", cannot_read(where), count));
} catch (const std::length_error&) {
  throw StorageError(
      fmt::format("{}: its {} values do not fit into memory", cannot_read(where), count));
}

template <class T>
std::vector<T> read_numbers(const Source& source, hid_t memory_type) {
  std::vector<T> values = sized<T>(source.count, source.where);
  source.read(memory_type, values.data());
  return values;
}

std::vector<std::int64_t> read_integers(const Source& source) {
  const bool is_wide_unsigned = H5Tget_class(source.type) == H5T_INTEGER &&
                                H5Tget_sign(source.type) == H5T_SGN_NONE &&
                                H5Tget_size(source.type) >= sizeof(std::uint64_t);
  if (!is_wide_unsigned) return read_numbers<std::int64_t>(source, H5T_NATIVE_INT64);
  const std::vector<std::uint64_t> wide = read_numbers<std::uint64_t>(source, H5T_NATIVE_UINT64);
  constexpr auto kLargest = static_cast<std::uint64_t>(std::numeric_limits<std::int64_t>::max());
  for (std::size_t row = 0; row < wide.size(); ++row)
    if (wide[row] > kLargest)
      throw InputError(fmt::format("{} holds {} in row {}; integers up to 2^63 - 1 are allowed",
                                   source.where, wide[row], row + 1));
  return {wide.begin(), wide.end()};
}

std::vector<std::string> read_variable_texts(const Source& source) {
  if (source.count == 0) return {};
  const std::string what = cannot_read(source.where);
  const Handle memory_type(checked(H5Tcopy(H5T_C_S1), what), H5Tclose);
  checked(H5Tset_size(memory_type.get(), H5T_VARIABLE), what);
  checked(H5Tset_cset(memory_type.get(), H5Tget_cset(source.type)), what);
  std::vector<char*> pointers = sized<char*>(source.count, source.where);
  source.read(memory_type.get(), pointers.data());
  std::vector<std::string> texts;
  texts.reserve(pointers.size());
  for (const char* pointer : pointers) texts.emplace_back(pointer == nullptr ? "" : pointer);
  checked(H5Dvlen_reclaim(memory_type.get(), source.space, H5P_DEFAULT, pointers.data()), what);
  return texts;
}

std::vector<std::string> read_fixed_texts(const Source& source) {
  const std::size_t size = H5Tget_size(source.type);
  if (size != 0 && source.count > std::numeric_limits<std::size_t>::max() / size)
    throw StorageError(fmt::format("{}: its size is damaged", cannot_read(source.where)));
  std::vector<char> bytes = sized<char>(source.count * size, source.where);
  source.read(source.type, bytes.data());
  const char padding = H5Tget_strpad(source.type) == H5T_STR_SPACEPAD ? ' ' : '\0';
  std::vector<std::string> texts;
  texts.reserve(source.count);
  for (std::size_t row = 0; row < source.count; ++row) {
    std::string_view text(bytes.data() + row * size, size);
    if (padding == '\0') text = text.substr(0, text.find('\0'));
    while (!text.empty() && text.back() == padding) text.remove_suffix(1);
    texts.emplace_back(text);
  }
  return texts;
}

/// Nothing if the type is neither number nor text.
std::optional<Values> read_known(const Source& source) {
  switch (H5Tget_class(source.type)) {
    case H5T_FLOAT:
      return read_numbers<double>(source, H5T_NATIVE_DOUBLE);
    case H5T_INTEGER:
    case H5T_ENUM:  // h5py's booleans
      return read_integers(source);
    case H5T_STRING:
      return H5Tis_variable_str(source.type) > 0 ? read_variable_texts(source)
                                                 : read_fixed_texts(source);
    default:
      return std::nullopt;
  }
}

std::size_t element_count(hid_t space, const std::string& where) {
  const hssize_t count = checked(H5Sget_simple_extent_npoints(space), cannot_read(where));
  return static_cast<std::size_t>(count);
}

Handle text_type(const std::string& where) {
  const std::string what = cannot_write(where);
  Handle type(checked(H5Tcopy(H5T_C_S1), what), H5Tclose);
  checked(H5Tset_size(type.get(), H5T_VARIABLE), what);
  checked(H5Tset_cset(type.get(), H5T_CSET_UTF8), what);
  return type;
}

std::vector<const char*> pointers_to(const std::vector<std::string>& texts) {
  std::vector<const char*> pointers;
  pointers.reserve(texts.size());
  for (const std::string& text : texts) pointers.push_back(text.c_str());
  return pointers;
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

void create_attribute(const Object& object, const std::string& name, hid_t file_type,
                      hid_t memory_type, const void* data, std::optional<hsize_t> extent) {
  const std::string what = fmt::format("cannot write attribute \"{}\" of {}", name, object.where);
  const Handle space(
      checked(extent ? H5Screate_simple(1, &*extent, nullptr) : H5Screate(H5S_SCALAR), what),
      H5Sclose);
  const Handle attribute(checked(H5Acreate2(object.id(), name.c_str(), file_type, space.get(),
                                            H5P_DEFAULT, H5P_DEFAULT),
                                 what),
                         H5Aclose);
  if (extent != hsize_t{0}) checked(H5Awrite(attribute.get(), memory_type, data), what);
}

Attribute as_attribute(Values values, bool is_scalar) {
  if (auto* doubles = std::get_if<std::vector<double>>(&values)) {
    if (is_scalar) return doubles->front();
    return std::move(*doubles);
  }
  if (auto* integers = std::get_if<std::vector<std::int64_t>>(&values)) {
    if (is_scalar) return integers->front();
    return std::vector<double>(integers->begin(), integers->end());
  }
  auto& texts = std::get<std::vector<std::string>>(values);
  if (is_scalar) return std::move(texts.front());
  return std::move(texts);
}

}  // namespace

Object open_dataset(const Object& group, const std::string& name) {
  const std::string where =
      fmt::format("{}{}{}", group.where, group.where.ends_with('/') ? "" : "/", name);
  if (H5Lexists(group.id(), name.c_str(), H5P_DEFAULT) <= 0)
    throw StorageError(fmt::format(
        "cannot read {}: the table's column order names it, but it is not there", where));
  const hid_t id = H5Dopen2(group.id(), name.c_str(), H5P_DEFAULT);
  return {Handle(checked(id, fmt::format("{}: it is damaged or no dataset", cannot_read(where))),
                 H5Dclose),
          where};
}

std::optional<std::vector<hsize_t>> extents(const Object& dataset) {
  const std::string what = cannot_read(dataset.where);
  const Handle space(checked(H5Dget_space(dataset.id()), what), H5Sclose);
  if (H5Sget_simple_extent_type(space.get()) == H5S_NULL) return std::nullopt;
  const int rank = checked(H5Sget_simple_extent_ndims(space.get()), what);
  std::vector<hsize_t> result(static_cast<std::size_t>(rank));
  checked(H5Sget_simple_extent_dims(space.get(), result.data(), nullptr), what);
  return result;
}

Values read_values(const Object& dataset) {
  const std::string what = cannot_read(dataset.where);
  const Handle type(checked(H5Dget_type(dataset.id()), what), H5Tclose);
  const Handle space(checked(H5Dget_space(dataset.id()), what), H5Sclose);
  const Source source{.type = type.get(),
                      .space = space.get(),
                      .count = element_count(space.get(), dataset.where),
                      .is_attribute = false,
                      .id = dataset.id(),
                      .where = dataset.where};
  std::optional<Values> values = read_known(source);
  if (!values)
    throw InputError(fmt::format(
        "{} has a type that is neither number nor text; a column of a table holds one of these",
        dataset.where));
  return std::move(*values);
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

std::optional<Attribute> read_attribute(const Object& object, const std::string& name) {
  const std::string where = fmt::format("attribute \"{}\" of {}", name, object.where);
  const htri_t exists = checked(H5Aexists(object.id(), name.c_str()), cannot_read(where));
  if (exists == 0) return std::nullopt;
  const Handle attribute(
      checked(H5Aopen(object.id(), name.c_str(), H5P_DEFAULT), cannot_read(where)), H5Aclose);
  const Handle type(checked(H5Aget_type(attribute.get()), cannot_read(where)), H5Tclose);
  const Handle space(checked(H5Aget_space(attribute.get()), cannot_read(where)), H5Sclose);
  const H5S_class_t shape = H5Sget_simple_extent_type(space.get());
  if (shape != H5S_SCALAR && H5Sget_simple_extent_ndims(space.get()) != 1) return std::nullopt;
  const Source source{.type = type.get(),
                      .space = space.get(),
                      .count = element_count(space.get(), where),
                      .is_attribute = true,
                      .id = attribute.get(),
                      .where = where};
  std::optional<Values> values = read_known(source);
  if (!values) return std::nullopt;
  return as_attribute(std::move(*values), shape == H5S_SCALAR);
}

Attributes read_attributes(const Object& object) {
  const std::string what = fmt::format("cannot read the attributes of {}", object.where);
  std::vector<std::string> names;
  hsize_t position = 0;
  checked(H5Aiterate2(
              object.id(), H5_INDEX_NAME, H5_ITER_INC, &position,
              [](hid_t, const char* name, const H5A_info_t*, void* list) -> herr_t {
                static_cast<std::vector<std::string>*>(list)->emplace_back(name);
                return 0;
              },
              &names),
          what);
  Attributes result;
  for (const std::string& name : names)
    if (auto value = read_attribute(object, name)) result.emplace(name, std::move(*value));
  return result;
}

void write_attribute(const Object& object, const std::string& name, const Attribute& value) {
  if (const auto* number = std::get_if<double>(&value))
    return create_attribute(object, name, H5T_IEEE_F64LE, H5T_NATIVE_DOUBLE, number, std::nullopt);
  if (const auto* integer = std::get_if<std::int64_t>(&value))
    return create_attribute(object, name, H5T_STD_I64LE, H5T_NATIVE_INT64, integer, std::nullopt);
  if (const auto* numbers = std::get_if<std::vector<double>>(&value))
    return create_attribute(object, name, H5T_IEEE_F64LE, H5T_NATIVE_DOUBLE, numbers->data(),
                            numbers->size());
  const Handle type = text_type(object.where);
  if (const auto* text = std::get_if<std::string>(&value)) {
    const char* pointer = text->c_str();
    return create_attribute(object, name, type.get(), type.get(), &pointer, std::nullopt);
  }
  const auto& texts = std::get<std::vector<std::string>>(value);
  const std::vector<const char*> pointers = pointers_to(texts);
  create_attribute(object, name, type.get(), type.get(), pointers.data(), texts.size());
}

}  // namespace repose::table::hdf5
