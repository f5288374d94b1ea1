// Errors that a user can act on, one type for each exit code of the programs.
#pragma once

#include <stdexcept>
#include <string>

namespace repose {

/// What went wrong; the value is the exit code of every repose program.
enum class ErrorKind {
  internal = 1,
  usage = 2,
  input = 3,
  numerical = 4,
  simulation = 5,
  storage = 6
};

/// Base of all exceptions thrown by repose. The message is one sentence that names the quantity,
/// its value, what is allowed and what to do.
class Error : public std::runtime_error {
 public:
  Error(ErrorKind kind, const std::string& message) : std::runtime_error(message), kind_(kind) {}
  ErrorKind kind() const { return kind_; }
  int exit_code() const { return static_cast<int>(kind_); }

 private:
  ErrorKind kind_;
};

/// The command line is wrong.
struct UsageError : Error {
  explicit UsageError(const std::string& message) : Error(ErrorKind::usage, message) {}
};
/// A file, a key or a value given by the user is wrong.
struct InputError : Error {
  explicit InputError(const std::string& message) : Error(ErrorKind::input, message) {}
};
/// A computation on valid input cannot give a number.
struct NumericalError : Error {
  explicit NumericalError(const std::string& message) : Error(ErrorKind::numerical, message) {}
};
/// A simulation failed: particles lost, nothing flows, the engine crashed.
struct SimulationError : Error {
  explicit SimulationError(const std::string& message) : Error(ErrorKind::simulation, message) {}
};
/// A file cannot be read, written or is damaged.
struct StorageError : Error {
  explicit StorageError(const std::string& message) : Error(ErrorKind::storage, message) {}
};

/// Throws an internal Error that names the broken invariant. Called by REPOSE_ASSERT only.
[[noreturn]] void assertion_failed(const char* expression, const char* file, int line,
                                   const std::string& values);

}  // namespace repose

/// An invariant of ours, kept in every build; `values` is a string with the numbers that broke it.
#define REPOSE_ASSERT(expression, values) \
  ((expression) ? static_cast<void>(0)    \
                : ::repose::assertion_failed(#expression, __FILE__, __LINE__, values))
