// repose measure PHOTO: from options to a view, and what any view is measured for.
#include <fmt/format.h>

#include "measure_options.hpp"
#include "repose/base/error.hpp"
#include "repose/base/file.hpp"
#include "repose/dem_adapter/picture.hpp"
#include "repose/dem_adapter/run_segregation.hpp"

namespace repose::cli {
namespace {

/// The same in the unit of a photograph's view: rows count downwards, z upwards.
dem_adapter::EdgeOptions edge_options_of_photograph(const MeasureOptions& o) {
  auto edge = edge_options(o);
  const double scale = o.scale.value_or(1.0);
  if (edge.axis_m) *edge.axis_m *= scale;
  if (edge.floor_m) *edge.floor_m *= -scale;
  if (edge.toe_m) *edge.toe_m *= scale;
  if (edge.outlet_m) edge.outlet_m = {o.outlet[0] * scale, o.outlet[1] * scale};
  return edge;
}

/// Of the camera, by two points that should be level.
double tilt_deg(const MeasureOptions& o) {
  if (o.level.empty()) return 0.0;
  return dem_adapter::tilt_deg({o.level[0], o.level[1]}, {o.level[2], o.level[3]});
}

dem_adapter::Picture upright(const MeasureOptions& o, const std::string& path) {
  auto picture = dem_adapter::read_picture(path);
  return o.level.empty() ? picture : leveled(picture, tilt_deg(o));
}

dem_adapter::Segmentation segmentation_of(const MeasureOptions& o,
                                          const dem_adapter::PixelBox& crop) {
  dem_adapter::Segmentation segmentation{.threshold = o.threshold};
  if (o.background.starts_with('#'))
    segmentation.background = dem_adapter::parse_color(o.background);
  else if (!o.background.empty())
    segmentation.background = cropped(upright(o, o.background), crop);
  for (const auto& component : o.components) {
    const auto equals = component.find('=');
    if (equals == std::string::npos || equals == 0)
      throw UsageError(
          fmt::format("--component {}: write NAME=COLOUR, e.g. pellet=#705040", component));
    segmentation.components.push_back(
        {.name = component.substr(0, equals),
         .color = dem_adapter::parse_color(component.substr(equals + 1))});
  }
  return segmentation;
}

dem_adapter::View photograph_view(const MeasureOptions& o) {
  const auto picture = upright(o, o.input);
  dem_adapter::PixelBox crop{.width = picture.width, .height = picture.height};
  if (!o.crop.empty()) crop = {o.crop[0], o.crop[1], o.crop[2], o.crop[3]};
  const auto part = cropped(picture, crop);
  return dem_adapter::view_of_photograph(part, segmentation_of(o, crop), o.scale, crop.column,
                                         crop.row);
}

}  // namespace

dem_adapter::EdgeOptions edge_options(const MeasureOptions& o) {
  dem_adapter::EdgeOptions edge{.shape = o.shape == "heap"     ? dem_adapter::EdgeShape::heap
                                         : o.shape == "slopes" ? dem_adapter::EdgeShape::slopes
                                                               : dem_adapter::EdgeShape::surface,
                                .axis_m = o.axis,
                                .floor_m = o.floor,
                                .toe_m = o.toe,
                                .from = o.from,
                                .to = o.to,
                                .fit = o.fit == "robust" ? dem_adapter::LineFit::robust
                                                         : dem_adapter::LineFit::least_squares};
  if (!o.outlet.empty()) edge.outlet_m = {o.outlet[0], o.outlet[1]};
  return edge;
}

dem_adapter::Measurement measured_view(const MeasureOptions& o, const dem_adapter::View& view,
                                       const dem_adapter::EdgeOptions& edge) {
  const auto angle = measure_angle(view, edge);
  auto m = angle.measurement;
  if (!o.slices.empty()) {
    auto slices = dem_adapter::measure_slices(view, o.slices[0], o.slices[1]);
    m.kpis.merge(slices.kpis);
    m.details.merge(slices.details);
  }
  if (!o.audit.empty()) write_file_atomically(o.audit, audit_svg(view, angle, o.input));
  return m;
}

Measured measure_photograph(const MeasureOptions& o) {
  Measured result{.measurement =
                      measured_view(o, photograph_view(o), edge_options_of_photograph(o))};
  if (!o.level.empty()) result.measurement.details["tilt_deg"] = tilt_deg(o);
  return result;
}

}  // namespace repose::cli
