// Materials, pairs and the contact model in a case file.
#include "case_io/parts.hpp"

namespace repose::scene {

Material read_material(const TomlTable& table) {
  Material material;
  material.name = table.text("name");
  material.density_kg_m3 = table.number("density_kg_m3", kPositive);
  material.poissons_ratio = table.number(
      "poissons_ratio", {.lower = -1.0, .upper = 0.5, .open_lower = true, .open_upper = false});
  if (table.has("shear_modulus_pa")) {
    if (table.has("youngs_modulus_pa"))
      table.fail("shear_modulus_pa", "stands beside youngs_modulus_pa; give one of them");
    material.youngs_modulus_pa =
        2.0 * table.number("shear_modulus_pa", kPositive) * (1.0 + material.poissons_ratio);
  } else {
    material.youngs_modulus_pa = table.number("youngs_modulus_pa", kPositive);
  }
  return material;
}

PairCoefficients read_pair(const TomlTable& table) {
  PairCoefficients pair;
  const std::vector<std::string> names = table.texts("materials");
  if (names.size() != 2)
    table.fail("materials",
               "has " + std::to_string(names.size()) + " names; give two, [\"a\", \"b\"]");
  pair.first = names[0];
  pair.second = names[1];
  pair.restitution = table.number("restitution", {.lower = 0.0, .upper = 1.0, .open_lower = true});
  pair.mu_s = table.number("mu_s", kNonNegative);
  pair.mu_r = table.number("mu_r", kNonNegative);
  pair.rolling_damping = table.number_or("rolling_damping", pair.rolling_damping, kNonNegative);
  pair.cohesion_energy_density_j_m3 =
      table.number_or("cohesion_energy_density_j_m3", 0.0, kNonNegative);
  return pair;
}

ContactModel read_contact(const TomlTable& table) {
  ContactModel model;
  if (table.choice_or("tail", "keep", {"keep", "clip"}) == "clip") model.tail = Tail::clip;
  if (table.choice_or("rolling", "C", {"A", "C"}) == "A") model.rolling = RollingModel::a;
  if (table.choice_or("rolling_stiffness", "ai", {"ai", "kt"}) == "kt")
    model.rolling_stiffness = RollingStiffness::kt;
  if (table.choice_or("compat", "none", {"none", "liggghts"}) == "liggghts")
    model.compatibility = Compatibility::liggghts;
  return model;
}

void write_materials(CaseText& out, const Case& scene) {
  for (const Material& material : scene.materials) {
    out.heading("[[material]]");
    out.put("name", material.name);
    out.put("density_kg_m3", material.density_kg_m3);
    out.put("youngs_modulus_pa", material.youngs_modulus_pa);
    out.put("poissons_ratio", material.poissons_ratio);
  }
  for (const PairCoefficients& pair : scene.pairs) {
    out.heading("[[pair]]");
    out.put("materials", std::vector<std::string>{pair.first, pair.second});
    out.put("restitution", pair.restitution);
    out.put("mu_s", pair.mu_s);
    out.put("mu_r", pair.mu_r);
    out.put("rolling_damping", pair.rolling_damping);
    out.put("cohesion_energy_density_j_m3", pair.cohesion_energy_density_j_m3);
  }
}

void write_contact(CaseText& out, const ContactModel& model) {
  out.heading("[contact]");
  out.put("tail", model.tail == Tail::keep ? "keep" : "clip");
  out.put("rolling", model.rolling == RollingModel::c ? "C" : "A");
  out.put("rolling_stiffness", model.rolling_stiffness == RollingStiffness::ai ? "ai" : "kt");
  out.put("compat", model.compatibility == Compatibility::none ? "none" : "liggghts");
}

}  // namespace repose::scene
