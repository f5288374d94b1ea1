#include "repose/base/error.hpp"

#include <fmt/format.h>

namespace repose {

void assertion_failed(const char* expression, const char* file, int line,
                      const std::string& values) {
  throw Error(ErrorKind::internal,
              fmt::format("internal error at {}:{}: `{}` does not hold ({}); please report it",
                          file, line, expression, values));
}

}  // namespace repose
