#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <optional>
#include <set>

#include "command_engine.hpp"
#include "extraction.hpp"
#include "placeholders.hpp"
#include "repose/base/error.hpp"
#include "repose/base/file.hpp"
#include "repose/base/text.hpp"
#include "repose/dem_adapter/command.hpp"

namespace repose::dem_adapter {
namespace {

namespace fs = std::filesystem;

struct Kpi {
  std::string name;
  Extraction extraction;
};
struct Echo {
  std::string parameter;
  Extraction extraction;
  double tolerance = 1e-9;  ///< relative
};

/// Letters, digits and _, not beginning with a digit.
bool is_plain(const std::string& name) {
  const auto is_letter = [](char c) {
    return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || c == '_';
  };
  return !name.empty() && is_letter(name.front()) &&
         std::all_of(name.begin(), name.end(),
                     [&](char c) { return is_letter(c) || (c >= '0' && c <= '9'); });
}

/// Where a file lies while the command runs: as in the scenario's folder, or in the uppermost if it
/// is taken from elsewhere.
std::string name_in_run(const std::string& file) {
  const fs::path normal = fs::path(file).lexically_normal();
  return normal.is_absolute() || *normal.begin() == ".." ? normal.filename().string()
                                                         : normal.string();
}

void add_files(const TomlTable& table, const char* key, FileUse use,
               std::vector<CommandFile>& files) {
  if (!table.has(key)) return;
  const auto folder = fs::path(table.file()).parent_path();
  for (const auto& file : table.texts(key)) {
    const auto source = folder / file;
    if (file.empty() || !fs::is_regular_file(source))
      table.fail(key, fmt::format("there is no file '{}'", source.string()));
    CommandFile added{.name = name_in_run(file), .content = read_file(source), .use = use};
    constexpr auto kAny = fs::perms::owner_exec | fs::perms::group_exec | fs::perms::others_exec;
    added.is_executable = (fs::status(source).permissions() & kAny) != fs::perms::none;
    if (added.name == "case.toml")
      table.fail(key, "case.toml is the name of what a run starts from; rename your file");
    for (const auto& other : files)
      if (other.name == added.name)
        table.fail(key,
                   fmt::format("two files would be called {} where the command runs", added.name));
    files.push_back(std::move(added));
  }
}

/// Placeholders of one text, all of them known; `what` says where it stands.
void note_used(const TomlTable& table, const char* key, const std::string& what,
               const std::string& text, const ParameterValues& parameters,
               std::set<std::string>& used) {
  std::vector<std::string> known = built_in_placeholders();
  for (const auto& [name, value] : parameters) known.push_back(name);
  std::vector<Placeholder> found;
  try {
    found = placeholders_of(text);
  } catch (const InputError& error) {
    table.fail(key, fmt::format("{}, {}", what, error.what()));
  }
  for (const auto& placeholder : found) {
    if (std::find(known.begin(), known.end(), placeholder.name) == known.end()) {
      const auto similar = closest_name(placeholder.name, known);
      table.fail(key, fmt::format("{}, line {}: there is no parameter for ${{{}}}; {}", what,
                                  placeholder.line, placeholder.name,
                                  similar.empty() ? "there are " + listed(known)
                                                  : "did you mean " + similar + "?"));
    }
    used.insert(placeholder.name);
  }
}

/// Every placeholder has a parameter and every parameter a placeholder.
void check_placeholders(const TomlTable& table, const UserCommand& command,
                        const ParameterValues& parameters) {
  std::set<std::string> used;
  for (const auto& word : command.words)
    note_used(table, "command", fmt::format("\"{}\"", word), word, parameters, used);
  for (const auto& file : command.files)
    if (file.use == FileUse::filled_in)
      note_used(table, "templates", file.name, file.content, parameters, used);
  for (const auto& [name, value] : parameters)
    if (used.count(name) == 0)
      table.table("parameters")
          .fail(name, fmt::format("neither templates nor command have ${{{}}}, so it would change "
                                  "nothing; use it or leave it out",
                                  name));
}

std::vector<std::string> read_words(const TomlTable& table) {
  auto words = table.texts("command");
  if (words.empty() || words.front().empty())
    table.fail("command", "give the program and its arguments, e.g. [\"python3\", \"sim.py\"]");
  if (words.front().find("${") != std::string::npos)
    table.fail("command", "the program itself may not have placeholders");
  return words;
}

void check_program(const TomlTable& table, const UserCommand& command) {
  const auto& program = command.words.front();
  if (program.find('/') == std::string::npos || fs::path(program).is_absolute()) return;
  const auto name = fs::path(program).lexically_normal().string();
  const auto file = std::find_if(command.files.begin(), command.files.end(),
                                 [&](const CommandFile& f) { return f.name == name; });
  if (file == command.files.end())
    table.fail("command", fmt::format("{} is neither among files nor templates; add it, or give an "
                                      "absolute path",
                                      program));
  if (!file->is_executable)
    table.fail("command", fmt::format("{} is not executable; chmod +x, or name its interpreter "
                                      "first",
                                      program));
}

ParameterValues read_parameters(const TomlTable& table) {
  const auto parameters = table.table("parameters");
  ParameterValues values;
  for (const auto& name : parameters.keys()) {
    if (!is_plain(name)) parameters.fail(name, "a name may hold letters, digits and _ only");
    const auto& built_in = built_in_placeholders();
    if (std::find(built_in.begin(), built_in.end(), name) != built_in.end())
      parameters.fail(
          name, fmt::format("${{{}}} is there without a parameter; choose another name", name));
    values[name] = parameters.number(name);
  }
  return values;
}

std::vector<Kpi> read_kpis(const TomlTable& table) {
  std::vector<Kpi> kpis;
  for (const auto& t : table.tables("kpi")) {
    auto name = t.text("name");
    if (!is_plain(name)) t.fail("name", "a name may hold letters, digits and _ only");
    for (const auto& other : kpis)
      if (other.name == name) t.fail("name", "there is another KPI of this name");
    kpis.push_back({std::move(name), read_extraction(t)});
  }
  if (kpis.empty()) table.fail("", "there is no KPI; give at least one [[kpi]]");
  return kpis;
}

std::vector<Echo> read_echoes(const TomlTable& table, const ParameterValues& parameters) {
  std::vector<Echo> echoes;
  const auto all = table.table_if_present("echo");
  if (!all) return echoes;
  for (const auto& name : all->keys()) {
    if (parameters.count(name) == 0) all->fail(name, "there is no parameter of this name");
    const auto t = all->table(name);
    Echo echo{.parameter = name, .extraction = read_extraction(t)};
    echo.tolerance = t.number_or("tolerance", echo.tolerance, kNonNegative);
    if (std::holds_alternative<ParticleAngle>(echo.extraction.number))
      t.fail("shape", "an angle repeats no parameter; take it from JSON, a table or a text");
    echoes.push_back(std::move(echo));
  }
  return echoes;
}

std::vector<FailureSign> read_signs(const TomlTable& table) {
  std::vector<FailureSign> signs;
  const auto outcomes = table.table_if_present("outcomes");
  if (!outcomes) return signs;
  for (const auto& name : outcomes->keys()) {
    FailureSign sign{
        .outcome = Outcome::engine_failed, .pattern = outcomes->text(name), .compiled = {}};
    try {
      sign.outcome = outcome_named(name);
      sign.compiled.assign(sign.pattern, std::regex::ECMAScript);
    } catch (const InputError& error) {
      outcomes->fail(name, error.what());
    } catch (const std::regex_error& error) {
      outcomes->fail(name, fmt::format("this is no regular expression: {}", error.what()));
    }
    if (!is_failure(sign.outcome)) outcomes->fail(name, "a command that failed has no KPIs");
    signs.push_back(std::move(sign));
  }
  return signs;
}

/// The number; errors name `what` it is.
double number_of(const std::string& what, const Extraction& extraction, const fs::path& output) {
  try {
    return extracted(extraction, output, output.parent_path() / "engine.log");
  } catch (const StorageError& error) {
    throw StorageError(fmt::format("{}: {}", what, error.what()));
  } catch (const InputError& error) {
    throw InputError(fmt::format("{}: {}", what, error.what()));
  }
}

/// Empty if the command used what it was given.
std::string mismatch(const Echo& echo, const CommandInput& given, const fs::path& output) {
  const double value = given.values.at(echo.parameter);
  const double used = number_of("echo of " + echo.parameter, echo.extraction, output);
  if (std::abs(used - value) <= echo.tolerance * std::abs(value)) return "";
  return fmt::format(
      "the command says that it used {} = {}, but {} was given; look where the placeholder stands "
      "in its input",
      echo.parameter, shortest(used), shortest(value));
}

}  // namespace

struct CommandScenario::Definition {
  std::string title;
  UserCommand command;
  ParameterValues parameters;
  std::vector<Kpi> kpis;
  std::vector<Echo> echoes;
};

CommandScenario::CommandScenario(std::shared_ptr<const Definition> definition)
    : definition_(std::move(definition)) {}

CommandScenario CommandScenario::read(const TomlTable& table) {
  auto d = std::make_shared<Definition>();
  d->title = table.text_or("title", "command");
  d->command.words = read_words(table);
  d->command.version = table.text_or("version", "");
  add_files(table, "templates", FileUse::filled_in, d->command.files);
  add_files(table, "files", FileUse::copied, d->command.files);
  d->command.signs = read_signs(table);
  check_program(table, d->command);
  d->parameters = read_parameters(table);
  check_placeholders(table, d->command, d->parameters);
  d->kpis = read_kpis(table);
  d->echoes = read_echoes(table, d->parameters);
  return CommandScenario(std::move(d));
}

std::string CommandScenario::name() const {
  return definition_->title;
}

std::vector<std::string> CommandScenario::parameter_names() const {
  std::vector<std::string> names;
  for (const auto& [name, value] : definition_->parameters) names.push_back(name);
  return names;
}

std::vector<std::string> CommandScenario::kpi_names() const {
  std::vector<std::string> names;
  for (const auto& kpi : definition_->kpis) names.push_back(kpi.name);
  return names;
}

RunInput CommandScenario::make_input(const ParameterValues& values, std::uint64_t seed) const {
  CommandInput input{.seed = seed, .values = definition_->parameters};
  for (auto& [name, value] : input.values) {
    if (const auto given = values.find(name); given != values.end()) value = given->second;
    if (!std::isfinite(value))
      throw InputError(fmt::format("{} = {}: it must be a finite number", name, value));
  }
  return {.seed = seed, .text = command_input_text(input)};
}

Measurement CommandScenario::measure(const fs::path& output) const {
  Measurement m;
  if (!definition_->echoes.empty()) {
    const auto given = read_command_input(output / "case.toml");
    for (const auto& echo : definition_->echoes)
      if (auto wrong = mismatch(echo, given, output); !wrong.empty()) {
        m.fail(Outcome::engine_failed, std::move(wrong));
        return m;
      }
  }
  for (const auto& kpi : definition_->kpis)
    m.kpis[kpi.name] = number_of("KPI " + kpi.name, kpi.extraction, output);
  m.drop_undefined_kpis();
  return m;
}

std::string CommandScenario::kpi_definition() const {
  std::string text;
  for (const auto& kpi : definition_->kpis)
    text += fmt::format("{}={}\n", kpi.name, kpi.extraction.definition);
  for (const auto& echo : definition_->echoes)
    text += fmt::format("echo {}={} {}\n", echo.parameter, echo.extraction.definition,
                        shortest(echo.tolerance));
  return text;
}

Engine CommandScenario::make_engine(const Executor& executor) const {
  return CommandEngine(definition_->title, definition_->command, executor);
}

}  // namespace repose::dem_adapter
