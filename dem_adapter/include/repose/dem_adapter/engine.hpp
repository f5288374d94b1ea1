// An engine runs one case in one folder; whoever has these members is one.
#pragma once

#include <concepts>
#include <filesystem>
#include <functional>
#include <memory>
#include <string>

#include "repose/dem_adapter/executor.hpp"
#include "repose/dem_adapter/outcome.hpp"

namespace repose::dem_adapter {

/// Where the engine's own words go: into its log, or to the terminal with its progress.
enum class EngineStreams { to_log, inherited };

/// One simulation to be done. `directory` holds case.toml; the engine writes its output folder
/// `directory`/output and appends what it says to `directory`/engine.log as it says it. A run that
/// was cancelled or timed out may leave a scene::checkpoint_file() in its output folder; then it
/// finds the folder as it left it when it is run again, else there is none.
struct EngineJob {
  std::filesystem::path directory;
  int ranks = 1;                    ///< processes that simulate together
  double time_limit_s = 0.0;        ///< 0: none
  std::function<bool()> cancelled;  ///< asked often; true when the run is to be given up
  EngineStreams streams = EngineStreams::to_log;
  /// A stage at whose end the engine is to wait, leaving a scene::checkpoint_file(); empty: none.
  /// Only for engines that wait after stages.
  std::string until{};
};

/// `killed`: by somebody else, which says nothing about the run.
enum class EngineStatus { finished, failed, timed_out, cancelled, killed };

struct EngineExit {
  EngineStatus status = EngineStatus::failed;
  Outcome failure = Outcome::engine_failed;  ///< by name, where status is failed
  std::string message;                       ///< why it did not finish, in one sentence
  Resources resources;
};

template <class E>
concept EngineLike = requires(const E& e, const EngineJob& job) {
  { e.name() } -> std::convertible_to<std::string>;
  { e.run(job) } -> std::convertible_to<EngineExit>;
};

/// An engine with `static constexpr bool kWaitsAfterStages = true` follows EngineJob::until, and
/// goes on from such a checkpoint also in the folder of a case of which only later stages differ.
template <class E>
constexpr bool waits_after_stages() {
  if constexpr (requires { E::kWaitsAfterStages; })
    return E::kWaitsAfterStages;
  else
    return false;
}

/// Any engine as a value. run() may be called from several threads at once.
class Engine {
 public:
  template <EngineLike E>
  requires(!std::same_as<std::remove_cvref_t<E>, Engine>) Engine(E engine)
      : model_(std::make_shared<const Model<E>>(std::move(engine))) {}
  /// With its version and build: part of what names a run.
  std::string name() const { return model_->name(); }
  EngineExit run(const EngineJob& job) const { return model_->run(job); }
  bool waits_after_stages() const { return model_->waits_after_stages(); }

 private:
  struct Interface {
    virtual ~Interface() = default;
    virtual std::string name() const = 0;
    virtual EngineExit run(const EngineJob& job) const = 0;
    virtual bool waits_after_stages() const = 0;
  };
  template <class E>
  struct Model final : Interface {
    explicit Model(E e) : engine(std::move(e)) {}
    std::string name() const override { return engine.name(); }
    EngineExit run(const EngineJob& job) const override { return engine.run(job); }
    bool waits_after_stages() const override { return dem_adapter::waits_after_stages<E>(); }
    E engine;
  };
  std::shared_ptr<const Interface> model_;
};

/// The bundled engine: the program repose-dem.
class BundledEngine {
 public:
  static constexpr bool kWaitsAfterStages = true;
  /// `program` empty: repose-dem beside the running program, then on PATH. A run that is told to
  /// end has `grace_s` for its checkpoint before it is killed. Throws StorageError if there is no
  /// program, InputError for a grace below 0.
  explicit BundledEngine(std::filesystem::path program = {}, double grace_s = 10.0,
                         Executor executor = LocalExecutor());
  std::string name() const;
  /// Throws the Error of the engine where no run could succeed: bad input, a full disk.
  EngineExit run(const EngineJob& job) const;

 private:
  std::filesystem::path program_;
  double grace_s_;
  Executor executor_;
  std::string name_;
};

}  // namespace repose::dem_adapter
