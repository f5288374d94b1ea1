#include "repose/dem_adapter/compute_plan.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <thread>

#include "repose/base/error.hpp"
#include "repose/base/text.hpp"

namespace repose::dem_adapter {

namespace {

unsigned jobs_at_once(const ComputePlan& plan) {
  if (plan.cores > 0 || plan.memory_gb > 0.0)
    throw InputError(
        "cores and memory_gb are of this machine, and the runs go to the queue of SLURM; leave "
        "them "
        "out, [slurm] max_jobs says how many runs may stand in the queue");
  const auto most = static_cast<unsigned>(plan.slurm->max_jobs);
  return plan.workers == 0 ? most : std::min(plan.workers, most);
}

SlurmOptions read_slurm(const TomlTable& root) {
  SlurmOptions slurm;
  const auto t = root.table_if_present("slurm");
  if (!t) return slurm;
  slurm.partition = t->text_or("partition", "");
  slurm.account = t->text_or("account", "");
  slurm.max_jobs =
      static_cast<int>(t->integer_or("max_jobs", slurm.max_jobs, {.lower = 1, .upper = 4096}));
  if (t->has("extra_options")) slurm.extra_options = t->texts("extra_options");
  for (const auto& option : slurm.extra_options)
    if (!option.starts_with("-"))
      t->fail("extra_options",
              fmt::format("\"{}\" is no option of sbatch; write each as \"--name=value\"", option));
  slurm.setup = t->text_or("setup", "");
  slurm.ask_every_s = t->number_or("ask_every_s", slurm.ask_every_s, {.lower = 1.0});
  return slurm;
}

}  // namespace

unsigned runs_at_once(const ComputePlan& plan) {
  if (plan.slurm) return jobs_at_once(plan);
  const int here = std::max(1, static_cast<int>(std::thread::hardware_concurrency()));
  const int cores = plan.cores > 0 ? plan.cores : std::max(here, plan.ranks);
  if (plan.ranks > cores)
    throw InputError(
        fmt::format("ranks = {} exceeds cores = {}: a run needs as many cores as it has processes",
                    plan.ranks, cores));
  int fitting = cores / plan.ranks;
  if (plan.memory_gb > 0.0) {
    if (!(plan.memory_per_run_gb > 0.0))
      throw InputError(fmt::format(
          "memory_gb = {} without memory_per_run_gb: give what one run needs; the table of a "
          "campaign has peak_memory_bytes of finished runs",
          shortest(plan.memory_gb)));
    const double runs = std::floor(plan.memory_gb / plan.memory_per_run_gb * (1.0 + 1e-12));
    if (runs < 1.0)
      throw InputError(fmt::format("memory_per_run_gb = {} exceeds memory_gb = {}: no run fits",
                                   shortest(plan.memory_per_run_gb), shortest(plan.memory_gb)));
    fitting = static_cast<int>(std::min(runs, static_cast<double>(fitting)));
  }
  const auto most = static_cast<unsigned>(fitting);
  return plan.workers == 0 ? most
                           : (plan.cores > 0 || plan.memory_gb > 0.0 ? std::min(plan.workers, most)
                                                                     : plan.workers);
}

ComputePlan read_compute_plan(const TomlTable& root, const std::filesystem::path& folder) {
  ComputePlan plan;
  const auto t = root.table_if_present("compute");
  if (root.has("slurm") && !(t && t->has("executor")))
    root.fail("slurm", "add [compute] executor = \"slurm\", or \"local\" to leave it unused");
  const auto slurm = read_slurm(root);
  if (!t) return plan;
  plan.workers = static_cast<unsigned>(t->integer_or("workers", 0, {.lower = 0, .upper = 4096}));
  plan.cores = static_cast<int>(t->integer_or("cores", 0, {.lower = 0, .upper = 4096}));
  plan.ranks = static_cast<int>(t->integer_or("ranks", 1, {.lower = 1, .upper = 1024}));
  plan.memory_gb = t->number_or("memory_gb", 0.0, kNonNegative);
  plan.memory_per_run_gb = t->number_or("memory_per_run_gb", 0.0, kNonNegative);
  plan.time_limit_s = t->number_or("time_limit_s", plan.time_limit_s, kNonNegative);
  if (!t->flag_or("share_beginnings", true)) plan.beginnings = Beginnings::own;
  if (t->has("store")) {
    const auto store = t->text("store");
    if (store.empty()) t->fail("store", "it is empty; name a folder, or leave it out");
    plan.store = (folder / store).lexically_normal();
  }
  if (t->choice_or("executor", "local", {"local", "slurm"}) == "slurm") plan.slurm = slurm;
  try {
    static_cast<void>(runs_at_once(plan));
  } catch (const InputError& error) {
    t->fail("", error.what());
  }
  return plan;
}

Executor executor_of(const ComputePlan& plan, const std::filesystem::path& directory,
                     std::function<void(std::string)> warn) {
  if (!plan.slurm) return LocalExecutor();
  auto options = *plan.slurm;
  options.memory_per_run_gb = plan.memory_per_run_gb;
  options.warn = std::move(warn);
  return SlurmExecutor(std::move(options), directory / "slurm");
}

FailurePolicy read_failure_policy(const TomlTable& root, const std::vector<std::string>& kpis) {
  FailurePolicy policy;
  const auto t = root.table_if_present("failures");
  if (!t) return policy;
  policy.retries = static_cast<int>(t->integer_or("retries", 0, {.lower = 0, .upper = 100}));
  policy.stop_above =
      t->number_or("stop_above", 1.0, {.lower = 0.0, .upper = 1.0, .open_lower = true});
  if (t->has("retry_on")) {
    policy.retry_on.clear();
    for (const auto& name : t->texts("retry_on")) {
      try {
        policy.retry_on.push_back(outcome_named(name));
      } catch (const InputError& error) {
        t->fail("retry_on", error.what());
      }
      if (policy.retry_on.back() == Outcome::finished)
        t->fail("retry_on", "a finished run is not repeated; leave \"finished\" out");
    }
  }
  if (const auto penalty = t->table_if_present("penalty"))
    for (const auto& kpi : penalty->keys()) {
      if (std::find(kpis.begin(), kpis.end(), kpi) == kpis.end())
        penalty->fail(kpi,
                      fmt::format("the scenario has no KPI of this name; it has {}", listed(kpis)));
      policy.penalty[kpi] = penalty->number(kpi);
    }
  return policy;
}

}  // namespace repose::dem_adapter
