// An executor runs a program to its end, here or elsewhere; whoever has run() is one.
#pragma once

#include <concepts>
#include <filesystem>
#include <functional>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "repose/dem_adapter/outcome.hpp"

namespace repose::dem_adapter {

/// A program to be run. A program that is told to end gets SIGTERM, with all it started, and
/// SIGKILL when `grace_s` later it has not.
struct Command {
  std::vector<std::string> words;  ///< the program's path, then its arguments; there is no shell
  std::filesystem::path folder{};  ///< where it runs; empty: where we do
  std::filesystem::path log{};     ///< what it says is appended here; empty: it says it where we do
  int processes = 1;               ///< cores that it keeps busy
  double time_limit_s = 0.0;       ///< it is told to end then; 0: never
  double grace_s = 10.0;
  std::function<bool()> cancelled{};  ///< asked often; it is told to end when this is true
  /// A folder of this run alone, where an executor whose programs outlive us notes where its
  /// program is (submission.hpp).
  std::filesystem::path home{};
};

/// By itself, or because it was told to.
enum class CommandEnded { by_itself, at_time_limit, when_cancelled };

struct CommandEnd {
  CommandEnded ended = CommandEnded::by_itself;
  int exit_code = 0;  ///< 127 if the program could not be executed
  int signal = 0;     ///< that ended it, 0 for none
  Resources resources;
};

template <class E>
concept ExecutorLike = requires(const E& e, const Command& command) {
  { e.run(command) } -> std::convertible_to<CommandEnd>;
};

/// Any executor as a value. run() may be called from several threads at once; it throws
/// StorageError if the program cannot be started.
class Executor {
 public:
  template <ExecutorLike E>
  requires(!std::same_as<std::remove_cvref_t<E>, Executor>) Executor(E executor)
      : model_(std::make_shared<const Model<E>>(std::move(executor))) {}
  CommandEnd run(const Command& command) const { return model_->run(command); }

 private:
  struct Interface {
    virtual ~Interface() = default;
    virtual CommandEnd run(const Command& command) const = 0;
  };
  template <class E>
  struct Model final : Interface {
    explicit Model(E e) : executor(std::move(e)) {}
    CommandEnd run(const Command& command) const override { return executor.run(command); }
    E executor;
  };
  std::shared_ptr<const Interface> model_;
};

/// Children of this process, each in a process group of its own, which die with us. Throws
/// StorageError for a run that stands in a queue.
struct LocalExecutor {
  CommandEnd run(const Command& command) const;
};

}  // namespace repose::dem_adapter
