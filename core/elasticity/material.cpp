#include "core/elasticity/material.hpp"

#include <cmath>
#include <sstream>
#include <stdexcept>

namespace finegauge {

namespace {

[[noreturn]] void refuse(const char* field, double value, const char* range) {
  std::ostringstream message;
  message.precision(17);
  message << field << " is " << value << ", but must be " << range;
  throw std::invalid_argument(message.str());
}

}  // namespace

void check(const Material& material) {
  const double E = material.youngs_modulus;
  const double nu = material.poisson_ratio;
  if (!(E > 0.0 && std::isfinite(E))) refuse("youngs_modulus", E, "positive and finite [Pa]");
  if (!(nu > -1.0)) refuse("poisson_ratio", nu, "between -1 and 0.5, both excluded");
  if (!(nu < 0.5))
    refuse("poisson_ratio", nu,
           "between -1 and 0.5, both excluded: at 0.5 the bulk modulus is infinite and a displacement method has no "
           "stiffness");
}

}  // namespace finegauge
