#pragma once

namespace finegauge {

/// What a needle is made of. Round, solid, uniform; linear elastic in its own turning frame.
struct NeedleProperties {
  double youngs_modulus = 2.0e11;  ///< E [Pa]
  double poisson_ratio = 0.3;      ///< nu in (-1, 1/2)
  double radius = 1.0e-3;          ///< r [m]
  double density = 7.8e3;          ///< [kg/m³]
};

/// Stiffness of a cross section, whatever its shape; axes 2 and 3 are those of the element's rest frame.
struct BeamSection {
  double EA = 0.0;                ///< axial [N]
  double GA_2 = 0.0, GA_3 = 0.0;  ///< shear along axes 2 and 3, correction factor included [N]; infinite: no shear
                                  ///< (Bernoulli)
  double GJ = 0.0;                ///< torsion [N m²]
  double EI_2 = 0.0, EI_3 = 0.0;  ///< bending about axes 2 and 3 [N m²]
  double mass = 0.0;              ///< per length [kg/m]
  double polar_inertia = 0.0;     ///< rotary inertia about the axis, per length [kg m]; half of it across
};
/// Circular section; shear correction 6 (1 + nu) / (7 + 6 nu) (Cowper 1966). Throws std::invalid_argument with field,
/// value and range unless E, r, density > 0 and -1 < nu < 1/2.
BeamSection round_section(const NeedleProperties& properties);

}  // namespace finegauge
