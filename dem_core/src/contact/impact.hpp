// The elastic impact of two bodies, in closed form.
#pragma once

#include <cmath>

#include "repose/dem/pair_law.hpp"

namespace repose::dem {

/// Largest overlap of an impact at this relative speed without damping, m
/// [Johnson1985, section 11.4]: (15 m* v^2 / (16 sqrt(R*) E*))^(2/5).
inline double impact_overlap(double e_eff, const ContactBodies& bodies, double speed) {
  return std::pow(15.0 * bodies.m_eff * speed * speed / (16.0 * std::sqrt(bodies.r_eff) * e_eff),
                  0.4);
}

/// The relative speed at which impact_overlap() is `overlap`, m/s.
inline double impact_speed(double e_eff, const ContactBodies& bodies, double overlap) {
  return std::sqrt(16.0 * std::sqrt(bodies.r_eff) * e_eff * std::pow(overlap, 2.5) /
                   (15.0 * bodies.m_eff));
}

}  // namespace repose::dem
