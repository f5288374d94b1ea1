// The tables of a case file, each with its reader and its writer.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "case_io/values.hpp"
#include "repose/scene/case.hpp"

namespace repose::scene {

Material read_material(const TomlTable& table);
PairCoefficients read_pair(const TomlTable& table);
ContactModel read_contact(const TomlTable& table);
void write_materials(CaseText& out, const Case& scene);
void write_contact(CaseText& out, const ContactModel& model);

Wall read_wall(const TomlTable& table, const Folder& folder);
std::vector<Wall> read_box(const TomlTable& table);
Motion read_motion(const TomlTable& table);
void write_wall(CaseText& out, const Wall& wall);
void write_motion(CaseText& out, const Motion& motion);

ClumpShape read_clump(const TomlTable& table);
/// `mixture`, or `material`, `clump` and `sizes` of the table itself for one kind.
std::vector<Grains> read_mixture(const TomlTable& table);
void write_clump(CaseText& out, const ClumpShape& clump);
/// `heading` is that of the kinds of a mixture, e.g. "[[rain.mixture]]"; they end the table.
void write_mixture(CaseText& out, const std::vector<Grains>& mixture, const std::string& heading);

Fill read_fill(const TomlTable& table);
Rain read_rain(const TomlTable& table);
ParticleTable read_particle_table(const TomlTable& table, const Folder& folder);
Particle read_particle(const TomlTable& table);
void write_insertion(CaseText& out, const Case& scene);

Region read_region(const TomlTable& table);
Stage read_stage(const TomlTable& table);
Output read_output(const TomlTable& table);
void write_region(CaseText& out, const Region& region);
void write_stage(CaseText& out, const Stage& stage);
void write_output(CaseText& out, const Output& output);

}  // namespace repose::scene
