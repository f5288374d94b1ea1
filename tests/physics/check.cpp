#include "check.hpp"

#include <cmath>

namespace repose::physics {

bool Check::passed() const {
  switch (demand) {
    case Demand::near:
      return std::abs(result - reference) <= tolerance;
    case Demand::at_most:
      return result <= reference + tolerance;
    case Demand::at_least:
      return result >= reference - tolerance;
    case Demand::report:
      return true;
  }
  return false;
}

const std::vector<Group>& all_groups() {
  static const std::vector<Group> kGroups{
      {"chung_ooi", "Chung and Ooi's eight impact tests",
       "[Chung2011]. Tests 1 and 2 against Hertz [Johnson1985]; 4 to 6 over their whole ranges "
       "against "
       "an independent integration of the same law (tests/data/dem), whose digits and step make "
       "the "
       "tolerance, and against rigid-body theory in full sliding. With `tail = \"keep\"` test 6 is "
       "off in "
       "full sliding by design: only `clip` is exact there.",
       chung_ooi},
      {"restitution", "Restitution over e and speed",
       "A sphere of 5 mm on a plane; damping is of first order in the time step.", restitution},
      {"oblique", "No impact gains energy",
       "Kinetic energy after an oblique impact on a plane over that before, the largest over all "
       "angles and frictions.",
       oblique_impacts},
      {"rolling", "Sliding and rolling on a plane",
       "R = 5 mm, 2500 kg/m³, E = 50 MPa, ν = 0.3, μ = 0.5, μ_r = 0.1, η_r = 0.3. Type C: "
       "mobilised, a = (5/7) g (sin θ − μ_r cos θ); else an oscillator of k_r and 1.4 m R². Type A "
       "has no spring: it can stop a sphere but not hold it on a slope.",
       sliding_and_rolling},
      {"rotating_frame", "A contact seen from a rotating frame",
       "Two spheres held together by cohesion, wound up against each other in sliding and rolling, "
       "no losses; the pair turns as a whole.",
       rotating_frame},
      {"angular_momentum", "Angular momentum, orbital and spin",
       "Contact forces act in one point and rolling torques are opposite: only rounding is left.",
       angular_momentum},
      {"elastic_gas", "Energy of an elastic gas",
       "27 spheres in a periodic box, no friction, 1 m/s. The error comes from where in a step a "
       "contact "
       "begins, so it walks at random and falls with the step.",
       elastic_gas},
      {"time_step", "Order of the time step",
       "log₂ of the ratio of errors per halving of the step, from 200 to 1600 steps a contact. A "
       "contact that begins inside a step lowers the elastic order from 2 to 1.5 at worst.",
       time_step_order},
      {"size_ratio", "A grain between spheres that are much larger",
       "[Vyas2025]: two frozen spheres side by side, a grain rolls down the groove between them, "
       "μ = 0.8. Without the update synchronised with the half step the history presses it into "
       "the "
       "wedge, and it sticks for ever.",
       size_ratio},
      {"clumps", "Clumps",
       "Second moments of two overlapping spheres in closed form, five distances; free precession "
       "of "
       "a symmetric top, whose axis turns about L with |L|/A; a body that tumbles about its "
       "unstable "
       "axis; two clumps that collide.",
       clumps},
      {"meshes", "Triangles against primitives",
       "A sphere of 10 mm slips and rolls over triangles as over what they stand for. Curved "
       "surfaces "
       "of radius 0.1 m: the sagitta of a strip goes with the square of its width, and with it "
       "both "
       "errors; what the sphere loses in the small impacts at hollow edges scatters about that, so "
       "that ten is asked of the sixteen that two halvings give.",
       meshes},
      {"drums", "Torque, power and momentum of a turning drum",
       "200 spheres in a cylinder that turns with 4 rad/s. Torques are summed over ten steps by "
       "trapezoids, which limits the balance to the square of that span over a contact's.",
       drums},
      {"beverloo", "Discharge: Beverloo's law",
       "d = 4 mm ± 10 %, flat floor, periodic sides of 25 d. W = C ρ_b √g (D − k d)^2.5 with C "
       "from "
       "0.55 to 0.65 and k from 1.3 to 1.5 [Beverloo1961], [Mankoc2007]; the thin slot has the "
       "power "
       "1.5 and C near 1.03.",
       beverloo},
      {"angle_of_repose", "The angle of repose rises with friction",
       "Quick draw-down rig, one coefficient for all pairs.", angle_of_repose}};
  return kGroups;
}

}  // namespace repose::physics
