// The readers behind read_picture(), each the only place that knows its C library.
#pragma once

#include <string>

#include "repose/dem_adapter/picture.hpp"

namespace repose::dem_adapter {

/// `name` is the file's in messages. Throw InputError.
Picture read_png(const std::string& bytes, const std::string& name);
Picture read_jpeg(const std::string& bytes, const std::string& name);

/// Throws InputError for a picture too small or too large to measure.
void check_size(const std::string& name, std::size_t width, std::size_t height);

}  // namespace repose::dem_adapter
