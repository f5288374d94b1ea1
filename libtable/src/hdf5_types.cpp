// Elements of HDF5's types as numbers and texts.
#include "hdf5_types.hpp"

#include <fmt/format.h>

#include <limits>
#include <new>
#include <stdexcept>

#include "repose/base/error.hpp"

namespace repose::table::hdf5 {
namespace {

template <class T>
std::vector<T> sized(std::size_t count, const std::string& where) try {
  return std::vector<T>(count);
} catch (const std::bad_alloc&) {
  throw StorageError(
      fmt::format("cannot read {}: its {} values do not fit into memory", where, count));
} catch (const std::length_error&) {
  throw StorageError(
      fmt::format("cannot read {}: its {} values do not fit into memory", where, count));
}

template <class T>
std::vector<T> read_numbers(const Source& source, hid_t memory_type) {
  std::vector<T> values = sized<T>(source.count, source.where);
  if (source.count == 0) return values;  // HDF5 refuses the null pointer of an empty vector
  source.fetch(memory_type, values.data());
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
  const std::string what = fmt::format("cannot read {}", source.where);
  const Handle memory_type(checked(H5Tcopy(H5T_C_S1), what), H5Tclose);
  checked(H5Tset_size(memory_type.get(), H5T_VARIABLE), what);
  checked(H5Tset_cset(memory_type.get(), H5Tget_cset(source.type)), what);
  std::vector<char*> pointers = sized<char*>(source.count, source.where);
  source.fetch(memory_type.get(), pointers.data());
  std::vector<std::string> texts;
  texts.reserve(pointers.size());
  for (const char* pointer : pointers) texts.emplace_back(pointer == nullptr ? "" : pointer);
  const hsize_t extent = source.count;
  const Handle space(checked(H5Screate_simple(1, &extent, nullptr), what), H5Sclose);
  checked(H5Dvlen_reclaim(memory_type.get(), space.get(), H5P_DEFAULT, pointers.data()), what);
  return texts;
}

std::vector<std::string> read_fixed_texts(const Source& source) {
  const std::size_t size = H5Tget_size(source.type);
  if (size != 0 && source.count > std::numeric_limits<std::size_t>::max() / size)
    throw StorageError(fmt::format("cannot read {}: its size is damaged", source.where));
  std::vector<char> bytes = sized<char>(source.count * size, source.where);
  if (source.count == 0) return {};
  source.fetch(source.type, bytes.data());
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

/// PyTables' booleans.
std::optional<Values> read_bits(const Source& source) {
  if (H5Tget_size(source.type) != 1) return std::nullopt;
  const std::vector<std::uint8_t> bits = read_numbers<std::uint8_t>(source, H5T_NATIVE_B8);
  return std::vector<std::int64_t>(bits.begin(), bits.end());
}

}  // namespace

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
    case H5T_BITFIELD:
      return read_bits(source);
    default:
      return std::nullopt;
  }
}

Handle text_type(const std::string& where) {
  const std::string what = fmt::format("cannot write {}", where);
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

}  // namespace repose::table::hdf5
