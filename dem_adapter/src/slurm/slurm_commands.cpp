#include "slurm_commands.hpp"

#include <fmt/format.h>
#include <sys/mman.h>
#include <unistd.h>

#include <array>
#include <atomic>
#include <charconv>
#include <chrono>
#include <cmath>
#include <cstring>
#include <sstream>

#include "engine/programs.hpp"
#include "repose/base/error.hpp"
#include "repose/base/file.hpp"
#include "repose/base/text.hpp"

namespace repose::dem_adapter {
namespace {

namespace fs = std::filesystem;

constexpr char kPrefix[] = "repose-";
constexpr double kAnswerLimit_s = 120.0;
constexpr double kStartMargin_s = 60.0;  // of a job beside its program: setup, file systems

struct Said {
  int exit_code = -1;
  std::string text;
};

/// What a client of SLURM says, on both streams; a file in memory takes it.
Said said_by(std::vector<std::string> words, const std::function<bool()>& given_up = {}) {
  words.front() = find_program(words.front(), "install the Debian package slurm-client").string();
  const int memory = ::memfd_create("said", MFD_CLOEXEC);
  if (memory < 0)
    throw Error(ErrorKind::internal, fmt::format("no file in memory: {}", std::strerror(errno)));
  const auto log = fmt::format("/proc/{}/fd/{}", ::getpid(), memory);
  Said said;
  try {
    const auto end = LocalExecutor().run({.words = std::move(words),
                                          .log = log,
                                          .time_limit_s = kAnswerLimit_s,
                                          .grace_s = 1.0,
                                          .cancelled = given_up});
    said.exit_code = end.ended == CommandEnded::by_itself && end.signal == 0 ? end.exit_code : -1;
    said.text = read_file(log);
  } catch (...) {
    ::close(memory);
    throw;
  }
  ::close(memory);
  return said;
}

bool has(const std::string& text, std::initializer_list<const char*> parts) {
  for (const char* part : parts)
    if (text.find(part) != std::string::npos) return true;
  return false;
}

std::string on_one_line(const std::string& text) {
  std::string line;
  std::istringstream in(text);
  for (std::string part; std::getline(in, part);)
    if (!part.empty()) line += (line.empty() ? "" : "; ") + part;
  return line.empty() ? "nothing" : line;
}

std::string shell_quoted(const std::string& text) {
  std::string quoted = "'";
  for (const char c : text) quoted += c == '\'' ? std::string("'\\''") : std::string(1, c);
  return quoted + "'";
}

/// %: a placeholder of sbatch.
std::string sbatch_path(const fs::path& path) {
  std::string text;
  for (const char c : path.string()) text += c == '%' ? std::string("%%") : std::string(1, c);
  return text;
}

bool is_over(const std::string& state) {
  return has(state, {"COMPLETED", "CANCELLED", "FAILED", "TIMEOUT", "NODE_FAIL", "PREEMPTED",
                     "BOOT_FAIL", "DEADLINE", "OUT_OF_MEMORY", "REVOKED"});
}

}  // namespace

void check_slurm_is_installed() {
  for (const char* name : {"sbatch", "squeue", "scancel"})
    static_cast<void>(find_program(name,
                                   "install the Debian package slurm-client, or leave out "
                                   "[compute] executor = \"slurm\""));
}

TaskNeeds needs_of(const Command& command) {
  TaskNeeds needs{.processes = command.processes};
  if (command.time_limit_s > 0.0)
    needs.minutes = static_cast<int>(
        std::ceil((command.time_limit_s + command.grace_s + kStartMargin_s) / 60.0));
  return needs;
}

std::vector<std::string> sbatch_words(const SlurmOptions& options, const TaskNeeds& needs,
                                      const fs::path& array, std::size_t tasks) {
  std::vector<std::string> words{"sbatch",
                                 "--parsable",
                                 "--job-name=" + array.filename().string(),
                                 fmt::format("--array=0-{}", tasks - 1),
                                 "--nodes=1",
                                 fmt::format("--ntasks={}", needs.processes),
                                 "--no-requeue",  // the campaign does again what was killed
                                 "--open-mode=append",
                                 "--output=" + sbatch_path(array) + "/%a.txt"};
  if (needs.minutes > 0) words.push_back(fmt::format("--time={}", needs.minutes));
  if (options.memory_per_run_gb > 0.0)
    words.push_back(fmt::format("--mem={:.0f}M", std::ceil(1000.0 * options.memory_per_run_gb)));
  if (!options.partition.empty()) words.push_back("--partition=" + options.partition);
  if (!options.account.empty()) words.push_back("--account=" + options.account);
  words.insert(words.end(), options.extra_options.begin(), options.extra_options.end());
  words.push_back((array / "job.sh").string());
  return words;
}

SubmitAnswer meaning_of_sbatch(int exit_code, const std::string& said) {
  SubmitAnswer answer{.answer = Answer::silent, .job = "", .said = on_one_line(said)};
  if (exit_code == 0) {
    std::istringstream in(said);  // "12" or "12;CLUSTER", perhaps among warnings
    for (std::string line; std::getline(in, line);) {
      const auto digits = line.substr(0, line.find(';'));
      if (!digits.empty() && digits.find_first_not_of("0123456789") == std::string::npos)
        answer = {.answer = Answer::accepted, .job = digits, .said = ""};
    }
    return answer;
  }
  if (has(said, {"QOSMaxSubmitJob", "AssocMaxSubmitJob", "QOSGrpSubmitJobs", "AssocGrpSubmitJobs",
                 "job submit limit", "Reached maximum array", "temporarily unable to accept job"}))
    answer.answer = Answer::queue_full;
  else if (exit_code > 0 &&
           !has(said, {"Unable to contact", "ontroller", "timed out", "onnection", "Zero Bytes",
                       "ransport endpoint", "emporarily", "send/recv", "ommunication", "munge",
                       "Munge", "authentication"}))
    answer.answer = Answer::refused;
  return answer;
}

SubmitAnswer submit(const std::vector<std::string>& words) {
  const auto said = said_by(words);
  return meaning_of_sbatch(said.exit_code, said.text);
}

std::string key_refused(const std::string& said) {
  struct Sign {
    std::initializer_list<const char*> words;
    const char* key;
  };
  static const Sign kSigns[] = {
      {{"nvalid account"}, "[slurm] account"},
      {{"artition"}, "[slurm] partition"},
      {{"ime limit"}, "[compute] time_limit_s"},
      {{"job array", "array spec"}, "[slurm] max_jobs, which is the largest array"},
      {{"emory", "--mem"}, "[compute] memory_per_run_gb"},
      {{"option", "Invalid --"}, "[slurm] extra_options"},
      {{"node configuration", "ode count", "CPU count"}, "[compute] ranks and memory_per_run_gb"}};
  for (const auto& sign : kSigns)
    if (has(said, sign.words)) return sign.key;
  return "";
}

Queue parse_queue(const std::string& text) {
  Queue queue{.tasks = {}, .answered = true, .said = ""};
  std::istringstream in(text);
  for (std::string line; std::getline(in, line);) {
    if (!line.starts_with(kPrefix)) continue;
    std::istringstream fields(line);
    std::string task, job, state;
    QueuedTask q;
    std::getline(fields, q.array, '|');
    std::getline(fields, task, '|');
    std::getline(fields, job, '|');
    std::getline(fields, state, '|');
    std::getline(fields, q.reason);
    const auto [stop, code] = std::from_chars(task.data(), task.data() + task.size(), q.task);
    if (code != std::errc{} || stop != task.data() + task.size() || is_over(state)) continue;
    q.job = job + "_" + task;
    q.phase = state == "PENDING" ? JobPhase::pending : JobPhase::running;
    queue.tasks.push_back(std::move(q));
  }
  return queue;
}

Queue ask_queue(const std::function<bool()>& given_up) {
  const auto said = said_by({"squeue", "--noheader", "--array", "--states=all",
                             fmt::format("--user={}", ::getuid()), "--format=%j|%K|%F|%T|%r"},
                            given_up);
  if (said.exit_code == 0) return parse_queue(said.text);
  return {.tasks = {}, .answered = false, .said = on_one_line(said.text)};
}

bool cancel_jobs(const std::vector<std::string>& jobs) {
  std::vector<std::string> words{"scancel"};
  words.insert(words.end(), jobs.begin(), jobs.end());
  const auto said = said_by(words);
  // A job that is over cannot be cancelled: that is an answer.
  return said.exit_code == 0 || has(said.text, {"Invalid job id", "already completing"});
}

std::string job_script(const SlurmOptions& options, const fs::path& array) {
  return fmt::format(
      "#!/bin/bash\n"
      "# One task of this array is one run; what it does: repose campaign task --help\n"
      "set -e\n"
      "{}{}exec {} campaign task {} \"$SLURM_ARRAY_TASK_ID\"\n",
      options.setup, options.setup.empty() ? "" : "\n", shell_quoted(options.program.string()),
      shell_quoted(array.string()));
}

std::string new_array_name() {
  static std::atomic<unsigned> counter{0};
  std::array<char, 256> host{};
  ::gethostname(host.data(), host.size() - 1);
  return fmt::format(
      "{}{:016x}", kPrefix,
      content_hash(fmt::format("{} {} {} {}", host.data(), ::getpid(), counter++,
                               std::chrono::system_clock::now().time_since_epoch().count())));
}

}  // namespace repose::dem_adapter
