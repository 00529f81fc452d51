#include "core/needle/beam_section.hpp"

#include <cmath>
#include <numbers>
#include <sstream>
#include <stdexcept>

namespace finegauge {

namespace {

void require(bool holds, const char* field, double value, const char* range) {
  if (holds) return;
  std::ostringstream message;
  message.precision(17);
  message << field << " is " << value << ", but must be " << range;
  throw std::invalid_argument(message.str());
}

bool positive(double value) { return value > 0.0 && std::isfinite(value); }

}  // namespace

BeamSection round_section(const NeedleProperties& properties) {
  const double E = properties.youngs_modulus, nu = properties.poisson_ratio, r = properties.radius;
  require(positive(E), "youngs_modulus", E, "positive and finite [Pa]");
  require(nu > -1.0 && nu < 0.5, "poisson_ratio", nu, "between -1 and 0.5, both excluded");
  require(positive(r), "radius", r, "positive and finite [m]");
  require(positive(properties.density), "density", properties.density, "positive and finite [kg/m³]");
  const double G = E / (2.0 * (1.0 + nu));
  const double area = std::numbers::pi * r * r;
  const double I = 0.25 * area * r * r;  // second moment of area about a diameter
  const double k = 6.0 * (1.0 + nu) / (7.0 + 6.0 * nu);
  BeamSection section;
  section.EA = E * area;
  section.GA_2 = section.GA_3 = k * G * area;
  section.GJ = G * 2.0 * I;
  section.EI_2 = section.EI_3 = E * I;
  section.mass = properties.density * area;
  section.polar_inertia = properties.density * 2.0 * I;
  return section;
}

}  // namespace finegauge
