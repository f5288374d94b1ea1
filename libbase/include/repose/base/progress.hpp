// Progress with rate and time left: a redrawn line on a terminal, plain lines elsewhere.
#pragma once

#include <chrono>
#include <cstdio>
#include <functional>
#include <mutex>
#include <string>
#include <string_view>

namespace repose {

/// How far a library function has come: `done` of `total` in any unit, and a few words.
using ProgressCallback = std::function<void(double done, double total, std::string_view note)>;

enum class ProgressStyle { automatic, terminal, lines, quiet };

/// What a program shows of a ProgressCallback. Thread-safe. Lines never exceed 100 columns.
class ProgressDisplay {
 public:
  explicit ProgressDisplay(std::string label, ProgressStyle style = ProgressStyle::automatic,
                           std::FILE* out = stderr);
  ~ProgressDisplay();
  ProgressDisplay(const ProgressDisplay&) = delete;
  ProgressDisplay& operator=(const ProgressDisplay&) = delete;

  void update(double done, double total, std::string_view note = {});
  /// Ends the line; called by the destructor too.
  void finish();
  ProgressCallback callback();

 private:
  using Clock = std::chrono::steady_clock;
  std::mutex mutex_;
  std::string label_;
  ProgressStyle style_;
  std::FILE* out_;
  Clock::time_point start_;
  Clock::time_point last_shown_;
  double first_done_ = -1.0;
  std::string last_line_;
  bool line_open_ = false;
};

/// The text of one progress line, at most `columns` wide: label, bar, percentage, time left, note.
std::string progress_line(std::string_view label, double done, double total, double elapsed_s,
                          double done_at_start, std::string_view note, int columns = 100);

}  // namespace repose
