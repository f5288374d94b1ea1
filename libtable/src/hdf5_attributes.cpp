// Attributes of files, groups and datasets.
#include <fmt/format.h>

#include <utility>

#include "hdf5_types.hpp"
#include "repose/base/error.hpp"

namespace repose::table::hdf5 {
namespace {

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

std::optional<Attribute> read_attribute(const Object& object, const std::string& name) {
  const std::string where = fmt::format("attribute \"{}\" of {}", name, object.where);
  const std::string what = fmt::format("cannot read {}", where);
  const htri_t exists = checked(H5Aexists(object.id(), name.c_str()), what);
  if (exists == 0) return std::nullopt;
  const Handle attribute(checked(H5Aopen(object.id(), name.c_str(), H5P_DEFAULT), what), H5Aclose);
  const Handle type(checked(H5Aget_type(attribute.get()), what), H5Tclose);
  const Handle space(checked(H5Aget_space(attribute.get()), what), H5Sclose);
  const H5S_class_t shape = H5Sget_simple_extent_type(space.get());
  if (shape != H5S_SCALAR && H5Sget_simple_extent_ndims(space.get()) != 1) return std::nullopt;
  const hssize_t count = checked(H5Sget_simple_extent_npoints(space.get()), what);
  const Handle file(checked(H5Iget_file_id(object.id()), what), H5Fclose);
  hsize_t file_bytes = 0;
  checked(H5Fget_filesize(file.get(), &file_bytes), what);
  // Before there is memory for them: a damaged size would ask for all there is.
  if (static_cast<double>(count) * static_cast<double>(H5Tget_size(type.get())) >
      static_cast<double>(file_bytes))
    throw StorageError(
        fmt::format("{}: it is damaged: its {} values do not fit into the file", what, count));
  const Source source{.type = type.get(),
                      .count = static_cast<std::size_t>(count),
                      .where = where,
                      .fetch = [&](hid_t memory_type, void* data) {
                        checked(H5Aread(attribute.get(), memory_type, data),
                                fmt::format("{}: it is damaged", what));
                      }};
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
