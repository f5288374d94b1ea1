#include "repose/scene/case_keys.hpp"

#include <fmt/format.h>

#include <algorithm>

namespace repose::scene {
namespace {

constexpr std::string_view kOne = "1";
constexpr std::string_view kText = "text";
constexpr std::string_view kFlag = "true|false";
constexpr std::string_view kList = "list";
constexpr std::string_view kNone = "none";

const std::vector<CaseKey> kKeys = {
    {"", "gravity_m_s2", "m/s^2", "[0, 0, -9.81]", "[x, y, z]"},

    {"[run]", "seed", kOne, "1", "whole number below 2^63; the same seed gives the same bits"},
    {"[run]", "time_step_rayleigh_fraction", kOne, "0.15",
     "time step over the smallest Rayleigh time present, at most 0.5"},

    {"[domain]", "lower_m", "m", "", "[x, y, z]; a centre that leaves the domain is an error"},
    {"[domain]", "upper_m", "m", "", "[x, y, z]; the extent is the period of a periodic direction"},
    {"[domain]", "periodic", kList, "[]", "subset of [\"x\", \"y\", \"z\"]"},

    {"[contact]", "tail", kText, "\"keep\"",
     "attraction of damping before separation: \"keep\", or \"clip\" to F_n >= 0"},
    {"[contact]", "rolling", kText, "\"C\"",
     "rolling resistance: \"C\" spring and dashpot, \"A\" constant torque"},
    {"[contact]", "rolling_stiffness", kText, "\"ai\"",
     "of type C: \"ai\" 2.25 k_n (mu_r R*)^2, \"kt\" k_t R*^2"},
    {"[contact]", "compat", kText, "\"none\"",
     "\"liggghts\" follows that code's order of operations"},

    {"[[material]]", "name", kText, "", "differs from all others"},
    {"[[material]]", "density_kg_m3", "kg/m^3", "", "of the solid"},
    {"[[material]]", "youngs_modulus_pa", "Pa", "", "or shear_modulus_pa"},
    {"[[material]]", "shear_modulus_pa", "Pa", kNone,
     "instead of youngs_modulus_pa: E = 2 G (1 + nu)"},
    {"[[material]]", "poissons_ratio", kOne, "", "in (-1, 0.5]"},

    {"[[pair]]", "materials", kList, "", "[\"a\", \"b\"] in any order, each pair once"},
    {"[[pair]]", "restitution", kOne, "", "in (0, 1]"},
    {"[[pair]]", "mu_s", kOne, "", "sliding friction"},
    {"[[pair]]", "mu_r", kOne, "", "rolling friction"},
    {"[[pair]]", "rolling_damping", kOne, "0.3", "ratio to critical damping of the rolling spring"},
    {"[[pair]]", "cohesion_energy_density_j_m3", "J/m^3", "0",
     "simplified JKR: attraction of this times the contact area"},

    {"[[clump]]", "name", kText, "", "used as clump = \"NAME\"; \"sinter_3\" is there already"},
    {"[[clump]]", "spheres", kList, "", "[{position, radius}, ...], overlapping to one piece"},
    {"[[clump]] spheres", "position", "any", "", "[x, y, z] of a centre; only the form counts"},
    {"[[clump]] spheres", "radius", "any", "", "in the unit of position"},

    {"[[wall]]", "name", kText, "", "differs from all others"},
    {"[[wall]]", "material", kText, "", "name of a [[material]]"},
    {"[[wall]]", "shape", kText, "",
     "\"plane\" (origin_m, normal), \"rectangle\" (origin_m, edge_u_m, edge_v_m), \"disc\" "
     "(centre_m, normal, radius_m, inner_radius_m), \"cylinder\" (start_m, end_m, radius_m), "
     "\"cone\" (start_m, end_m, start_radius_m, end_radius_m) or \"mesh\" (file and what follows)"},
    {"[[wall]]", "origin_m", "m", "", "a point of the plane, a corner of the rectangle"},
    {"[[wall]]", "normal", kOne, "", "any length; of a plane towards the particles"},
    {"[[wall]]", "edge_u_m", "m", "", "edge of the rectangle from its corner"},
    {"[[wall]]", "edge_v_m", "m", "", "the other one, perpendicular"},
    {"[[wall]]", "centre_m", "m", "", "of the disc"},
    {"[[wall]]", "radius_m", "m", "", "of a disc or cylinder"},
    {"[[wall]]", "inner_radius_m", "m", "0", "above 0 the disc is a ring"},
    {"[[wall]]", "start_m", "m", "", "one end of the axis of a cylinder or cone; ends are open"},
    {"[[wall]]", "end_m", "m", "", "the other end"},
    {"[[wall]]", "start_radius_m", "m", "", "of a cone at start_m; 0 is a tip"},
    {"[[wall]]", "end_radius_m", "m", "", "of a cone at end_m"},
    {"[[wall]]", "file", kText, "", "STL, ASCII or binary; relative to the case file's folder"},
    {"[[wall]]", "scale", kOne, "1", "0.001 for a file in millimetres"},
    {"[[wall]]", "translation_m", "m", "[0, 0, 0]", "after scaling"},
    {"[[wall]]", "open", kFlag, "false", "the mesh may have a rim; else a rim is an error"},
    {"[[wall]]", "drop_degenerate", kFlag, "false",
     "leave triangles without area out; else they are an error"},
    {"[[wall]]", "smooth_deg", "degree", "5", "facets that meet at less are one smooth surface"},
    {"[[wall]]", "content_hash", kText, "the file's",
     "FNV-1a, 16 hexadecimal digits; a mesh that differs is refused"},

    {"[[box]]", "name", kText, "", "becomes walls NAME.-x, NAME.+x, ... NAME.+z"},
    {"[[box]]", "material", kText, "", "name of a [[material]]"},
    {"[[box]]", "lower_m", "m", "", "[x, y, z]"},
    {"[[box]]", "upper_m", "m", "", "[x, y, z]"},
    {"[[box]]", "open", kList, "[]", "faces left out, e.g. [\"+z\"]"},

    {"[[motion]]", "walls", kList, "", "names; that of a box means all of its faces"},
    {"[[motion]]", "type", kText, "",
     "\"translate\" (velocity_m_s), \"rotate\" (centre_m, axis, rate), \"oscillate\" (amplitude_m, "
     "frequency_hz, phase_rad) or \"table\" (points)"},
    {"[[motion]]", "velocity_m_s", "m/s", "", "[x, y, z]"},
    {"[[motion]]", "centre_m", "m", "", "a point of the axis"},
    {"[[motion]]", "axis", kOne, "", "any length; turns as a right-handed screw"},
    {"[[motion]]", "rate_rad_s", "rad/s", "", "or rate_rpm"},
    {"[[motion]]", "rate_rpm", "1/min", kNone, "instead of rate_rad_s"},
    {"[[motion]]", "amplitude_m", "m", "", "displacement A (sin(2 pi f t + phase) - sin(phase))"},
    {"[[motion]]", "frequency_hz", "Hz", "", "f"},
    {"[[motion]]", "phase_rad", "rad", "0", "phase"},
    {"[[motion]]", "points", kList, "",
     "[{time_s, displacement_m}, ...], linear in between, held outside"},
    {"[[motion]]", "stage", kText, "the run", "times count from the beginning of this stage"},
    {"[[motion]]", "start_s", "s", "0", "the wall rests before"},
    {"[[motion]]", "end_s", "s", "never", "the wall stays where it is afterwards"},
    {"[[motion]] points", "time_s", "s", "", "ascending, from start_s"},
    {"[[motion]] points", "displacement_m", "m", "",
     "[x, y, z]; first [0, 0, 0] unless the motion starts with the run"},

    {"[[region]]", "name", kText, "", "its mass is recorded as mass_NAME_kg"},
    {"[[region]]", "lower_m", "m", "-inf", "[x, y, z]"},
    {"[[region]]", "upper_m", "m", "inf", "[x, y, z]"},
    {"[[region]]", "x_above_m", "m", "-inf", "a single bound"},
    {"[[region]]", "x_below_m", "m", "inf", "a single bound"},
    {"[[region]]", "y_above_m", "m", "-inf", "a single bound"},
    {"[[region]]", "y_below_m", "m", "inf", "a single bound"},
    {"[[region]]", "z_above_m", "m", "-inf", "a single bound"},
    {"[[region]]", "z_below_m", "m", "inf", "a single bound"},
    {"[[region]]", "axis_start_m", "m", kNone, "limits the region to a cylinder"},
    {"[[region]]", "axis_end_m", "m", kNone, "the other end of its axis"},
    {"[[region]]", "radius_m", "m", kNone, "of that cylinder"},
    {"[[region]]", "removes", kFlag, "false", "particles that come in are taken out"},

    {"[fill]", "lower_m", "m", "", "[x, y, z] of the column that is filled"},
    {"[fill]", "upper_m", "m", "", "[x, y, z]"},
    {"[fill]", "solid_fraction", kOne, "0.33", "of the loose column, at most 0.36"},
    {"[fill]", "layer", kList, "", "[[fill.layer]], the lowest first"},
    {"[[fill.layer]]", "mass_kg", "kg", "", "of the layer"},
    {"[[fill.layer]]", "material", kText, "", "of one kind of particles"},
    {"[[fill.layer]]", "clump", kText, "spheres", "name of a [[clump]] or a shipped one"},
    {"[[fill.layer]]", "sizes", kList, "", "see sizes"},
    {"[[fill.layer]]", "mixture", kList, kNone, "instead of material, clump and sizes"},

    {"mixture", "material", kText, "", "of [{material, clump, mass_fraction, sizes}, ...]"},
    {"mixture", "clump", kText, "spheres", "name of a [[clump]] or a shipped one"},
    {"mixture", "mass_fraction", kOne, "", "all kinds sum to 1; 0: there is none"},
    {"mixture", "sizes", kList, "", "see sizes"},

    {"sizes = [{...}, ...]", "diameter_m", "m", "",
     "one size; of a clump: of the sphere of its "
     "volume"},
    {"sizes = [{...}, ...]", "lower_diameter_m", "m", "", "or a class, mass uniform over it"},
    {"sizes = [{...}, ...]", "upper_diameter_m", "m", "", "the other end of the class"},
    {"sizes = [{...}, ...]", "mass_fraction", kOne, "1", "all classes sum to 1"},
    {"sizes = {...}", "sieves_m", "m", "", "n + 1 ascending openings"},
    {"sizes = {...}", "mass_percent", "%", "", "n masses between them, sum 100"},
    {"sizes = {...}", "distribution", kText, "", "or \"log-normal\" or \"rosin-rammler\", by mass"},
    {"sizes = {...}", "median_diameter_m", "m", "", "log-normal: half of the mass is finer"},
    {"sizes = {...}", "geometric_sd", kOne, "",
     "log-normal: exp of the deviation of ln d, above 1"},
    {"sizes = {...}", "scale_diameter_m", "m", "", "rosin-rammler: 63.2 % of the mass is finer"},
    {"sizes = {...}", "spread", kOne, "", "rosin-rammler: larger is narrower"},
    {"sizes = {...}", "lower_diameter_m", "m", "", "of a distribution: nothing is finer"},
    {"sizes = {...}", "upper_diameter_m", "m", "", "of a distribution: nothing is coarser"},

    {"[[rain]]", "name", kText, "", "differs from all others"},
    {"[[rain]]", "mass_kg", "kg", "", "in all"},
    {"[[rain]]", "mass_rate_kg_s", "kg/s", "", "until the mass is in"},
    {"[[rain]]", "lower_m", "m", "", "[x, y, z] of the box that particles appear in"},
    {"[[rain]]", "upper_m", "m", "", "[x, y, z]"},
    {"[[rain]]", "velocity_m_s", "m/s", "[0, 0, 0]", "of every particle"},
    {"[[rain]]", "stage", kText, "the run", "start_s counts from the beginning of this stage"},
    {"[[rain]]", "start_s", "s", "0", "the first particle appears then"},
    {"[[rain]]", "material", kText, "", "of one kind of particles"},
    {"[[rain]]", "clump", kText, "spheres", "name of a [[clump]] or a shipped one"},
    {"[[rain]]", "sizes", kList, "", "see sizes"},
    {"[[rain]]", "mixture", kList, kNone, "instead of material, clump and sizes"},

    {"[[particle_table]]", "file", kText, "",
     "FILE.h5:/group, e.g. RUN.h5:/snapshots/000002, or FILE.csv; columns x_m, y_m, z_m, radius_m, "
     "material, clump, vx_m_s ..., wx_rad_s ..., qw, qx, qy, qz"},
    {"[[particle_table]]", "material", kText, kNone, "if the table has no column material"},
    {"[[particle_table]]", "clump", kText, "spheres", "if the table has no column clump"},
    {"[[particle_table]]", "content_hash", kText, "the file's", "as that of a mesh"},

    {"[[particle]]", "material", kText, "", "name of a [[material]]"},
    {"[[particle]]", "clump", kText, "sphere", "name of a [[clump]] or a shipped one"},
    {"[[particle]]", "radius_m", "m", "", "of a clump: of the sphere of its volume"},
    {"[[particle]]", "position_m", "m", "", "[x, y, z] of the centre of mass"},
    {"[[particle]]", "velocity_m_s", "m/s", "[0, 0, 0]", "at the start"},
    {"[[particle]]", "angular_velocity_rad_s", "rad/s", "[0, 0, 0]", "at the start"},
    {"[[particle]]", "orientation_wxyz", kOne, "[1, 0, 0, 0]",
     "unit quaternion from the principal axes to the world"},

    {"[[stage]]", "name", kText, "", "differs from all others"},
    {"[[stage]]", "opens", kList, "[]", "walls or boxes taken away at its beginning"},
    {"[[stage]]", "duration_s", "s", "", "at most"},
    {"[[stage]]", "minimum_s", "s", "0", "no criterion ends it earlier"},
    {"[[stage]]", "at_rest", kList, kNone, "ends the stage when particles rest: {...}"},
    {"[[stage]]", "flow_ends", kList, kNone,
     "ends the stage when a region no longer empties: {...}"},
    {"[[stage]]", "coefficients", kList, kNone, "of all pairs while the stage lasts: {...}"},
    {"[[stage]] coefficients", "restitution", kOne, "", "in (0, 1], in place of that of the pair"},
    {"[[stage]] coefficients", "mu_s", kOne, "", "sliding friction"},
    {"[[stage]] coefficients", "mu_r", kOne, "", "rolling friction"},
    {"[[stage]] at_rest", "kinetic_energy_ratio", kOne, "1e-4", "below this times sum(m g d_mean)"},
    {"[[stage]] at_rest", "window_s", "s", "0.05", "for this long"},
    {"[[stage]] flow_ends", "region", kText, "", "name of a [[region]]"},
    {"[[stage]] flow_ends", "fraction", kOne, "0.005", "less than this of what has left it leaves"},
    {"[[stage]] flow_ends", "window_s", "s", "0.2", "during this time"},

    {"[output]", "snapshot_interval_s", "s", "0", "0: only at the end of each stage"},
    {"[output]", "series_interval_s", "s", "0.005", "rows of the time series"},
    {"[output]", "vtp", kFlag, "false", "snapshots also as VTP files for ParaView"},
    {"[output]", "energy", kFlag, "false", "the energy ledger"},
    {"[output]", "checkpoint_wall_time_s", "s", "300",
     "wall time between checkpoints; 0: only on signals"},

    {"[parameters]", "NAME", "any", kNone,
     "what the case was made from, any names: recorded, without effect"},
};

/// Appends words to lines of at most `columns`, later lines indented.
void append_wrapped(std::string& out, std::string line, std::string_view words, std::size_t indent,
                    std::size_t columns) {
  while (!words.empty()) {
    const std::string_view word = words.substr(0, words.find(' '));
    words.remove_prefix(std::min(words.size(), word.size() + 1));
    if (line.size() > indent && line.size() + word.size() > columns) {
      out += line.substr(0, line.find_last_not_of(' ') + 1) + "\n";
      line = std::string(indent, ' ');
    }
    line += word;
    line += ' ';
  }
  out += line.substr(0, line.find_last_not_of(' ') + 1) + "\n";
}

}  // namespace

const std::vector<CaseKey>& case_keys() {
  return kKeys;
}

std::string case_keys_text(std::size_t columns) {
  std::string out;
  std::string_view table = "";
  for (const CaseKey& key : kKeys) {
    if (key.table != table) out += fmt::format("{}\n", key.table);
    table = key.table;
    const std::string initial =
        key.initial.empty() ? std::string("required") : fmt::format("({})", key.initial);
    std::string line = fmt::format("  {:<28} {:<10} {:<15} ", key.key, key.unit, initial);
    const std::size_t indent = 58;
    append_wrapped(out, std::move(line), key.meaning, indent, columns);
  }
  return out;
}

}  // namespace repose::scene
