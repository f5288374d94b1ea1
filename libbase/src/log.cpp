#include "repose/base/log.hpp"

#include <mutex>

namespace repose {
namespace {
std::mutex mutex;
LogSink current_sink;
}  // namespace

void set_log_sink(LogSink sink) {
  const std::lock_guard lock(mutex);
  current_sink = std::move(sink);
}

void log_message(LogLevel level, std::string_view message) {
  const std::lock_guard lock(mutex);
  if (current_sink) current_sink(level, message);
}

}  // namespace repose
