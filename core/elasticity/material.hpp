#pragma once

namespace finegauge {

/// How the volumetric part of a hexahedron's strain is integrated.
enum class Dilatation {
  standard,  ///< at each of the 2×2×2 points; locks as nu -> 1/2
  mean       ///< averaged over the cell (B-bar, Hughes 1980; mean dilatation, Nagtegaal et al. 1974)
};

/// Whether a cell's strain is measured in a frame that turns with the cell.
enum class Kinematics { linear, corotational };

/// Isotropic elasticity.
struct Material {
  double youngs_modulus = 1.0e3;  ///< E [Pa], > 0
  double poisson_ratio = 0.3;     ///< nu in (-1, 1/2)
  Dilatation dilatation = Dilatation::standard;
  Kinematics kinematics = Kinematics::linear;

  double mu() const { return youngs_modulus / (2.0 * (1.0 + poisson_ratio)); }  ///< shear modulus [Pa]
  double lambda() const {                                                        ///< Lamé's first parameter [Pa]
    return youngs_modulus * poisson_ratio / ((1.0 + poisson_ratio) * (1.0 - 2.0 * poisson_ratio));
  }
  double bulk() const { return lambda() + 2.0 / 3.0 * mu(); }  ///< bulk modulus [Pa]
};

/// Throws std::invalid_argument with field, value and range unless E > 0 and finite and -1 < nu < 1/2.
void check(const Material& material);

}  // namespace finegauge
