// KPIs as data: what is measured, where and when. A rig's [[kpi]] tables; scenarios in C++ may use
// them, too.
#pragma once

#include <optional>
#include <string>
#include <utility>
#include <variant>
#include <vector>

#include "repose/base/parameter_space.hpp"
#include "repose/base/toml.hpp"
#include "repose/dem_adapter/flow.hpp"
#include "repose/dem_adapter/measurement.hpp"
#include "repose/dem_adapter/run_segregation.hpp"
#include "repose/dem_adapter/view_angle.hpp"
#include "repose/scene/run_output.hpp"

namespace repose::dem_adapter {

// In all of them: `region` is one of the case's, "" everywhere; `stage` one of its stages, "" the
// last one; `material` one of its materials, "" all. Places are coordinates of the case.

enum class Side { both, left, right };
/// The last snapshot of a stage, or the mean over all of them.
enum class Sampled { at_end, throughout };

/// Degrees: the angle of the edge of what is seen of a region's grains (view_angle.hpp); its sides
/// and its lower end are those of the view.
struct AngleKpi {
  EdgeOptions edge{};
  Side side = Side::both;
  std::vector<ViewDirection> seen_along{ViewDirection::along_y};  ///< the mean of several
  std::string region{}, stage{};
  Sampled sampled = Sampled::at_end;
  double fastest_m_s = 0.2;  ///< faster grains are in flight
};

/// kg/s: out of a region in a stage; times of a window count from the stage's beginning.
struct MassFlowKpi {
  std::string region{}, stage{};
  FlowOptions flow{};
  double jammed_below = 0.0;  ///< a smaller share of the first mass that left is a jam
};

/// kg: in a region at the end of a stage, or a time after its beginning.
struct MassKpi {
  std::string region{}, material{}, stage{};
  std::optional<double> time_s{};
};

/// 1: the share of what was in a region at the beginning of a stage that left it.
struct FractionKpi {
  std::string region{}, material{}, stage{};
  double jammed_below = 0.0;
};

/// kg/m3: of the grains with centres in a region, a box inside the bed, at the end of a stage.
struct BulkDensityKpi {
  std::string region{}, stage{};
};

/// 1: mean SI of a material in what is in a region over time, with the 2 % rule.
struct SegregationOverTimeKpi {
  std::string region{}, material{};
};

/// 1: an index over the bins of a grid (GridOptions), at the end of a stage.
struct GridSegregationKpi {
  std::string index = "rsd";  ///< or lacey, ... (the indices of Table 2.2, docs/methods/kpis.md)
  std::string region{}, material{}, stage{};
  GridOptions grid{};
};

/// s: how long a stage was; with a region, when `share` of what left it in the stage was out.
struct DurationKpi {
  std::string stage{}, region{};
  double share = 0.98;
};

/// N or N m: on walls, mean over a stage; a component or the norm of the mean.
struct WallLoadKpi {
  enum class Load { force, torque } load = Load::force;
  enum class Component { x, y, z, norm } component = Component::z;
  std::string wall{}, stage{};  ///< the name of a box means all of its faces
};

/// N: mean normal force of the contacts of two materials over a stage.
struct ContactForceKpi {
  std::string first{}, second{}, stage{};
};

/// Arithmetic of given names and of KPIs that stand before it.
struct FormulaKpi {
  std::string formula{};  ///< without "="
};

using KpiKind = std::variant<AngleKpi, MassFlowKpi, MassKpi, FractionKpi, BulkDensityKpi,
                             SegregationOverTimeKpi, GridSegregationKpi, DurationKpi, WallLoadKpi,
                             ContactForceKpi, FormulaKpi>;

struct KpiDefinition {
  std::string name;  ///< its suffix is the unit: shear_angle_deg, mass_flow_kg_s
  KpiKind kind;
};

/// Reads the tables [[kpi]] (keys: docs/how-to/scenarios.md). Throws InputError with file and line,
/// also for a name whose suffix is not the unit of its kind.
std::vector<KpiDefinition> read_kpis(const std::vector<TomlTable>& tables);

/// Throws InputError if the case lacks a region, stage, material or wall that the KPI names.
void check_kpi(const KpiDefinition& kpi, const scene::Case& scene);

/// All of them, in turn; `names` are what formulas may use. One that the run does not determine is
/// missing with its reason (kpi_undefined); nothing_flowed and jammed_outlet leave none. Details
/// are named KPI.DETAIL.
Measurement measure_kpis(const std::vector<KpiDefinition>& kpis, const scene::Run& run,
                         const ParameterValues& names = {});

}  // namespace repose::dem_adapter
