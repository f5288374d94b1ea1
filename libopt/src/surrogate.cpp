#include "repose/opt/surrogate.hpp"

#include <fmt/format.h>

#include "repose/base/error.hpp"

namespace repose::opt {

void Surrogate::refuse(const char* what) {
  throw Error(ErrorKind::internal, fmt::format("this surrogate gives no {}", what));
}

}  // namespace repose::opt
