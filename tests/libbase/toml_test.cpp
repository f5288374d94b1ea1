// Strict TOML: values arrive, and every mistake is named with file, line, value and remedy.
#include "repose/base/toml.hpp"

#include <gtest/gtest.h>

#include "repose/base/error.hpp"

namespace repose {
namespace {

constexpr auto kText = R"(title = "x"
[run]
seed = 7
fraction = 0.25
[[layer]]
mass = 1
[[layer]]
mass = -2
)";

template <class Action>
std::string message_of(Action action) {
  try {
    action();
  } catch (const InputError& error) {
    return error.what();
  }
  return "no error";
}

TEST(Toml, ReadsWhatStandsThere) {
  const auto root = TomlTable::parse(kText, "f.toml");
  EXPECT_EQ(root.text("title"), "x");
  const auto run = root.table("run");
  EXPECT_EQ(run.integer("seed"), 7);
  EXPECT_DOUBLE_EQ(run.number("fraction"), 0.25);
  EXPECT_DOUBLE_EQ(run.number_or("absent", 3.0), 3.0);
  const auto layers = root.tables("layer");
  ASSERT_EQ(layers.size(), 2U);
  EXPECT_DOUBLE_EQ(layers[1].number("mass"), -2);
  EXPECT_EQ(root.keys(), (std::vector<std::string>{"title", "run", "layer"}));
  EXPECT_NO_THROW(static_cast<void>(layers[0].number("mass")));
  EXPECT_NO_THROW(root.refuse_unknown_keys());
}

TEST(Toml, NamesFileLineValueAndWhatIsAllowed) {
  const auto root = TomlTable::parse(kText, "f.toml");
  EXPECT_EQ(message_of([&] { root.tables("layer")[1].number("mass", kPositive); }),
            "f.toml:8: layer[2].mass: -2 is not allowed; it must be above 0");
  EXPECT_EQ(message_of([&] { root.table("run").text("seed"); }),
            "f.toml:3: run.seed: must be a text in quotes");
  EXPECT_EQ(message_of([&] { root.table("run").integer("fraction"); }),
            "f.toml:4: run.fraction: must be a whole number");
}

TEST(Toml, ReportsAMissingAndAnUnknownKeyWithTheLikelyOne) {
  const auto root = TomlTable::parse(kText, "f.toml");
  EXPECT_EQ(message_of([&] { root.table("run").number("fractoin"); }),
            "f.toml:2: run: the key fractoin is missing (there is fraction); add it");
  const auto other = TomlTable::parse("[run]\nsede = 7\n", "g.toml");
  static_cast<void>(other.table("run").integer_or("seed", 1));
  EXPECT_EQ(message_of([&] { other.refuse_unknown_keys(); }),
            "g.toml:2: run.sede: unknown key; did you mean seed?");
}

TEST(Toml, RefusesNonFiniteNumbersAndBrokenFiles) {
  const auto root = TomlTable::parse("a = nan\nb = inf\n", "f.toml");
  EXPECT_NE(message_of([&] { root.number("a"); }).find("f.toml:1: a: "), std::string::npos);
  EXPECT_NE(message_of([&] { root.number("b"); }).find("finite"), std::string::npos);
  EXPECT_NE(
      message_of([] { TomlTable::parse("a = \nb", "h.toml"); }).find("h.toml:1: not valid TOML"),
      std::string::npos);
}

/// a = 3, b = 0, whatever else is unknown; "a/b" is infinite.
double evaluated(const std::string& expression) {
  if (expression == " a") return 3.0;
  if (expression == " a / b") return std::numeric_limits<double>::infinity();
  if (expression == " 0 - a") return -3.0;
  if (expression == " a / 2") return 1.5;
  throw InputError("there is no parameter" + expression);
}

TEST(Toml, ExpressionsStandForNumbersAndForNothingElse) {
  const auto root = TomlTable::parse(
      "x = \"= a\"\n[t]\nlist = [1, \"= a / 2\"]\ntext = \"= a\"\n[[u]]\ny = \"= a\"\n", "f.toml");
  const auto with = root.with_expressions(evaluated);
  EXPECT_EQ(with.number("x"), 3.0);
  EXPECT_EQ(with.integer("x"), 3);
  EXPECT_EQ(with.table("t").numbers("list"), (std::vector<double>{1.0, 1.5}));
  EXPECT_EQ(with.table("t").text("text"), "= a");
  EXPECT_EQ(with.tables("u")[0].number_or("y", 0.0), 3.0);
  EXPECT_EQ(message_of([&] { root.number("x"); }), "f.toml:1: x: must be a number");
}

TEST(Toml, AWrongExpressionIsReportedWithFileLineAndKey) {
  const auto root =
      TomlTable::parse(
          "a = \"= c\"\nb = \"= a / b\"\nc = \"= 0 - a\"\nd = \"= a / 2\"\ne = \"a\"\n", "f.toml")
          .with_expressions(evaluated);
  EXPECT_EQ(message_of([&] { root.number("a"); }), "f.toml:1: a: \"= c\": there is no parameter c");
  EXPECT_EQ(message_of([&] { root.number("b"); }),
            "f.toml:2: b: \"= a / b\" = inf is not finite; give a finite number");
  EXPECT_EQ(message_of([&] { root.number("c", kPositive); }),
            "f.toml:3: c: \"= 0 - a\" = -3 is not allowed; it must be above 0");
  EXPECT_NE(message_of([&] { root.integer("d"); }).find("f.toml:4: d: \"= a / 2\" = 1.5 must be"),
            std::string::npos);
  EXPECT_NE(message_of([&] { root.number("e"); }).find("an expression"), std::string::npos);
}

TEST(Toml, ATableWithExpressionsKnowsNoKeysOfTheOneBefore) {
  const auto root = TomlTable::parse("x = 1\n", "f.toml");
  static_cast<void>(root.number("x"));
  EXPECT_THROW(root.with_expressions(evaluated).refuse_unknown_keys(), InputError);
}

TEST(Toml, QuotedTextReadsBack) {
  const std::string text = "a \"b\" \\ c\n\t";
  EXPECT_EQ(TomlTable::parse("k = " + toml_quoted(text), "q").text("k"), text);
}

}  // namespace
}  // namespace repose
