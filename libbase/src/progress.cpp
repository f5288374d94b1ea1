#include "repose/base/progress.hpp"

#include <fmt/format.h>
#include <sys/ioctl.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>

#include "repose/base/text.hpp"

namespace repose {
namespace {

constexpr double kTerminalInterval_s = 0.2;
constexpr double kLinesInterval_s = 15.0;

/// Bytes that begin a character: what a terminal gives a column to, for the texts shown here.
std::size_t columns_of(std::string_view text) {
  return static_cast<std::size_t>(
      std::count_if(text.begin(), text.end(), [](char c) { return (c & 0xC0) != 0x80; }));
}

std::string cut_to(std::string text, std::size_t columns) {
  while (columns_of(text) > columns) {
    while (!text.empty() && (text.back() & 0xC0) == 0x80) text.pop_back();
    if (!text.empty()) text.pop_back();
  }
  return text;
}

/// A line as wide as the terminal would wrap, and could not be redrawn.
int columns_of_terminal(std::FILE* out) {
  constexpr int kWidest = 100;
  struct winsize size {};
  if (::ioctl(::fileno(out), TIOCGWINSZ, &size) != 0 || size.ws_col == 0) return kWidest;
  return std::min(kWidest, size.ws_col - 1);
}

}  // namespace

std::string progress_line(std::string_view label, double done, double total, double elapsed_s,
                          double done_at_start, std::string_view note, int columns) {
  const double fraction = total > 0.0 ? std::clamp(done / total, 0.0, 1.0) : 0.0;
  constexpr int kBar = 20;
  const int filled = static_cast<int>(std::floor(fraction * kBar));
  std::string line = fmt::format(
      "{} [{}{}] {:3.0f} %", label, std::string(static_cast<std::size_t>(filled), '#'),
      std::string(static_cast<std::size_t>(kBar - filled), '.'), std::floor(100 * fraction));
  const double gained = done - done_at_start;
  if (fraction >= 1.0)
    line += fmt::format("  {}", duration_text(elapsed_s));
  else if (gained > 0.0 && elapsed_s > 0.5)
    line += fmt::format("  {} left", duration_text(elapsed_s / gained * (total - done)));
  if (!note.empty()) line += fmt::format("  {}", note);
  return cut_to(std::move(line), static_cast<std::size_t>(columns));
}

ProgressDisplay::ProgressDisplay(std::string label, ProgressStyle style, std::FILE* out)
    : label_(std::move(label)),
      style_(style),
      out_(out),
      start_(Clock::now()),
      last_shown_(start_) {
  if (style_ == ProgressStyle::automatic)
    style_ = ::isatty(::fileno(out)) != 0 ? ProgressStyle::terminal : ProgressStyle::lines;
}

ProgressDisplay::~ProgressDisplay() {
  finish();
}

void ProgressDisplay::update(double done, double total, std::string_view note) {
  if (style_ == ProgressStyle::quiet) return;
  const std::lock_guard lock(mutex_);
  const auto now = Clock::now();
  const bool first = first_done_ < 0.0;
  if (first) {
    first_done_ = done;
    start_ = now;
  }
  const bool complete = done >= total;
  const double interval =
      style_ == ProgressStyle::terminal ? kTerminalInterval_s : kLinesInterval_s;
  if (!complete && !first && std::chrono::duration<double>(now - last_shown_).count() < interval)
    return;
  if (first && style_ == ProgressStyle::lines && !complete) return;  // nothing to say yet
  const double elapsed = std::chrono::duration<double>(now - start_).count();
  auto line =
      progress_line(label_, done, total, elapsed, first_done_, note, columns_of_terminal(out_));
  if (line == last_line_) return;
  if (style_ == ProgressStyle::terminal) {
    std::fprintf(out_, "\r%s\033[K", line.c_str());
    line_open_ = true;
  } else {
    std::fprintf(out_, "%s\n", line.c_str());
  }
  std::fflush(out_);
  last_line_ = std::move(line);
  last_shown_ = now;
}

void ProgressDisplay::finish() {
  const std::lock_guard lock(mutex_);
  if (line_open_) std::fprintf(out_, "\n");
  line_open_ = false;
}

ProgressCallback ProgressDisplay::callback() {
  return [this](double done, double total, std::string_view note) { update(done, total, note); };
}

}  // namespace repose
