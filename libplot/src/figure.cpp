// The builder: checks what it is given and keeps it.
#include "repose/plot/figure.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numeric>
#include <utility>

#include "content.hpp"
#include "draw.hpp"
#include "repose/base/error.hpp"
#include "repose/base/text.hpp"
#include "style.hpp"

namespace repose::plot {
namespace {

std::vector<double> copied(std::span<const double> values) {
  return {values.begin(), values.end()};
}

void check_length(std::size_t length, std::size_t needed, const char* what, const char* of) {
  if (length == needed) return;
  throw InputError(
      fmt::format("{} of a figure has {} values, but there are {} {}", what, length, needed, of));
}

void check_optional_length(std::size_t length, std::size_t needed, const char* what) {
  if (length != 0) check_length(length, needed, what, "points");
}

void check_edges(std::span<const double> edges, Eigen::Index cells, const char* axis) {
  if (edges.size() != static_cast<std::size_t>(cells) + 1)
    throw InputError(fmt::format("a heat map with {} cells along {} needs {} edges, not {}", cells,
                                 axis, cells + 1, edges.size()));
  for (std::size_t i = 0; i < edges.size(); ++i)
    if (!std::isfinite(edges[i]) || (i > 0 && !(edges[i - 1] < edges[i])))
      throw InputError(
          fmt::format("edge {} of a heat map along {} is {}; edges must be finite and "
                      "ascend",
                      i + 1, axis, shortest(edges[i])));
}

void check_band(double lower, double upper) {
  if (std::isfinite(lower) && std::isfinite(upper) && lower <= upper) return;
  throw InputError(
      fmt::format("a band of a figure goes from {} to {}; both must be finite, the "
                  "first not larger",
                  shortest(lower), shortest(upper)));
}

void check_rule(double value) {
  if (!std::isfinite(value))
    throw InputError(
        fmt::format("a reference line of a figure lies at {}; it must be finite", shortest(value)));
}

void set_categories(std::vector<std::string>& known, const std::vector<std::string>& categories,
                    bool has_other_content) {
  if (categories.empty()) throw InputError("a figure with categories needs at least one");
  if (known.empty() && has_other_content)
    throw InputError("categories and points cannot share an axis; use two figures");
  if (!known.empty() && known != categories)
    throw InputError(fmt::format("the categories {} differ from those of the figure, {}",
                                 listed(categories), listed(known)));
  known = categories;
}

bool has_numbers(const FigureContent& content) {
  return !content.points.empty() || !content.curves.empty() || !content.ribbons.empty() ||
         content.has_diagonal;
}

void refuse_categories(const FigureContent& content) {
  if (!content.x_categories.empty() || !content.y_categories.empty())
    throw InputError("points and categories cannot share an axis; use two figures");
}

void add_to_legend(FigureContent& content, const std::string& label, LegendGlyph glyph) {
  if (label.empty()) return;
  const auto same = [&](const LegendEntry& entry) { return entry.label == label; };
  auto entry = std::find_if(content.legend.begin(), content.legend.end(), same);
  if (entry == content.legend.end()) entry = content.legend.insert(entry, {label, {}});
  entry->glyphs.push_back(std::move(glyph));
}

/// The series of this label: the one that has it, else a new one.
std::size_t series_of(FigureContent& content, const std::string& label, Glyph glyph,
                      LineStyle style = LineStyle::solid) {
  auto& labels = content.series_labels;
  const auto known = label.empty() ? labels.end() : std::find(labels.begin(), labels.end(), label);
  const auto series = static_cast<std::size_t>(known - labels.begin());
  if (known == labels.end()) labels.push_back(label);
  add_to_legend(content, label, {glyph, series_color(series), series, style});
  return series;
}

void check_colors(const Axis& color, ColorScale colors) {
  if (colors == ColorScale::diverging && color.scale == Scale::log)
    throw InputError(fmt::format("the colours of \"{}\" cannot diverge around zero on a log scale",
                                 color.label));
}

std::vector<double> category_edges(std::size_t n) {
  std::vector<double> edges(n + 1);
  std::iota(edges.begin(), edges.end(), 0.0);
  return edges;
}

}  // namespace

double quantile(const std::vector<double>& sorted, double p) {
  const double position = p * static_cast<double>(sorted.size() - 1);
  const auto low = static_cast<std::size_t>(position);
  const std::size_t high = std::min(low + 1, sorted.size() - 1);
  const double weight = position - static_cast<double>(low);
  return (1.0 - weight) * sorted[low] + weight * sorted[high];
}

Figure::Figure(std::string title, Axis x, Axis y, Size size)
    : content_(std::make_unique<FigureContent>()) {
  if (size.width < 160 || size.height < 120)
    throw InputError(fmt::format("a figure of {} x {} pixels is too small; it needs 160 x 120",
                                 size.width, size.height));
  content_->title = std::move(title);
  content_->x = std::move(x);
  content_->y = std::move(y);
  content_->size = size;
}
Figure::~Figure() = default;
Figure::Figure(Figure&&) noexcept = default;
Figure& Figure::operator=(Figure&&) noexcept = default;

Figure& Figure::scatter(std::span<const double> x, std::span<const double> y, std::string label,
                        ErrorBars errors) {
  check_length(y.size(), x.size(), "y", "values of x");
  check_optional_length(errors.x.size(), x.size(), "the error of x");
  check_optional_length(errors.y.size(), x.size(), "the error of y");
  refuse_categories(*content_);
  content_->points.push_back({copied(x), copied(y), copied(errors.x), copied(errors.y),
                              series_of(*content_, label, Glyph::marker)});
  return *this;
}

Figure& Figure::lines(std::span<const double> x, std::span<const double> y, std::string label,
                      LineStyle style) {
  check_length(y.size(), x.size(), "y", "values of x");
  refuse_categories(*content_);
  content_->curves.push_back(
      {copied(x), copied(y), style, series_of(*content_, label, Glyph::line, style)});
  return *this;
}

Figure& Figure::ribbon(std::span<const double> x, std::span<const double> lower,
                       std::span<const double> upper, std::string label) {
  check_length(lower.size(), x.size(), "the lower curve", "values of x");
  check_length(upper.size(), x.size(), "the upper curve", "values of x");
  refuse_categories(*content_);
  content_->ribbons.push_back(
      {copied(x), copied(lower), copied(upper), series_of(*content_, label, Glyph::ribbon)});
  return *this;
}

Figure& Figure::bars(const std::vector<std::string>& categories, std::span<const double> values,
                     std::string label, std::span<const double> errors) {
  check_length(values.size(), categories.size(), "a bar series", "categories");
  check_optional_length(errors.size(), values.size(), "the error of a bar series");
  set_categories(content_->x_categories, categories,
                 has_numbers(*content_) || !content_->y_categories.empty());
  content_->bars.push_back(
      {copied(values), copied(errors), series_of(*content_, label, Glyph::bar)});
  return *this;
}

Figure& Figure::horizontal_bars(const std::vector<std::string>& categories,
                                std::span<const double> values, std::string label,
                                std::span<const double> errors) {
  check_length(values.size(), categories.size(), "a bar series", "categories");
  check_optional_length(errors.size(), values.size(), "the error of a bar series");
  set_categories(content_->y_categories, categories,
                 has_numbers(*content_) || !content_->x_categories.empty());
  content_->bars.push_back(
      {copied(values), copied(errors), series_of(*content_, label, Glyph::bar)});
  return *this;
}

Figure& Figure::box(const std::vector<std::string>& categories,
                    const std::vector<std::vector<double>>& samples, std::string label) {
  check_length(samples.size(), categories.size(), "a box plot", "categories");
  set_categories(content_->x_categories, categories,
                 has_numbers(*content_) || !content_->y_categories.empty());
  content_->boxes.push_back({samples, series_of(*content_, label, Glyph::box)});
  return *this;
}

Figure& Figure::heat_map(std::span<const double> x_edges, std::span<const double> y_edges,
                         const Matrix& values, Axis color, ColorScale colors) {
  check_colors(color, colors);
  check_edges(x_edges, values.cols(), "x");
  check_edges(y_edges, values.rows(), "y");
  refuse_categories(*content_);
  if (content_->heat_map) throw InputError("a figure has room for one heat map");
  content_->heat_map =
      HeatMap{copied(x_edges), copied(y_edges), values, std::move(color), colors, CellText::hidden};
  return *this;
}

Figure& Figure::heat_map(const std::vector<std::string>& columns,
                         const std::vector<std::string>& rows, const Matrix& values, Axis color,
                         ColorScale colors, CellText text) {
  check_colors(color, colors);
  check_length(static_cast<std::size_t>(values.cols()), columns.size(), "a row of a heat map",
               "columns");
  check_length(static_cast<std::size_t>(values.rows()), rows.size(), "a column of a heat map",
               "rows");
  const bool is_taken = has_numbers(*content_) || !content_->bars.empty() ||
                        !content_->boxes.empty() || content_->heat_map;
  if (is_taken) throw InputError("a heat map of categories needs a figure of its own");
  set_categories(content_->x_categories, columns, false);
  set_categories(content_->y_categories, rows, false);
  content_->heat_map = HeatMap{category_edges(columns.size()),
                               category_edges(rows.size()),
                               values,
                               std::move(color),
                               colors,
                               text};
  return *this;
}

Figure& Figure::band(double lower, double upper, std::string label) {
  check_band(lower, upper);
  const char* color = band_color(content_->bands.size());
  content_->bands.push_back({Direction::horizontal, lower, upper, color});
  add_to_legend(*content_, label, {Glyph::band, color});
  return *this;
}

Figure& Figure::vertical_band(double lower, double upper, std::string label) {
  check_band(lower, upper);
  const char* color = band_color(content_->bands.size());
  content_->bands.push_back({Direction::vertical, lower, upper, color});
  add_to_legend(*content_, label, {Glyph::band, color});
  return *this;
}

Figure& Figure::horizontal_line(double y, std::string label) {
  check_rule(y);
  content_->rules.push_back({Direction::horizontal, y});
  add_to_legend(*content_, label, {Glyph::rule, kReferenceInk});
  return *this;
}

Figure& Figure::vertical_line(double x, std::string label) {
  check_rule(x);
  content_->rules.push_back({Direction::vertical, x});
  add_to_legend(*content_, label, {Glyph::rule, kReferenceInk});
  return *this;
}

Figure& Figure::diagonal(std::string label) {
  refuse_categories(*content_);
  if (content_->x.scale != content_->y.scale)
    throw InputError("the diagonal of a figure needs the same scale on both axes");
  content_->has_diagonal = true;
  add_to_legend(*content_, label, {Glyph::diagonal, kReferenceInk});
  return *this;
}

Figure& Figure::note(std::string text) {
  content_->notes.push_back(std::move(text));
  return *this;
}

std::string Figure::svg() const {
  return draw_figure(*content_);
}

}  // namespace repose::plot
