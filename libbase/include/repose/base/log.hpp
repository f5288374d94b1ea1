// Where libraries send what they have to say: to a sink that a program chooses, never to a stream.
#pragma once

#include <functional>
#include <string_view>

namespace repose {

enum class LogLevel { debug, info, warning };

using LogSink = std::function<void(LogLevel, std::string_view)>;

/// Replaces the sink of the whole process; an empty one (the default) drops every message.
void set_log_sink(LogSink sink);

/// Sends one line to the sink. Safe to call from several threads.
void log_message(LogLevel level, std::string_view message);

}  // namespace repose
