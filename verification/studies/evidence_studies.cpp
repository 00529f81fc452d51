#include "verification/studies/evidence_studies.hpp"

#include "verification/studies/atlas.hpp"
#include "verification/studies/determinism.hpp"
#include "verification/studies/estimator_ladder.hpp"
#include "verification/studies/friction_evidence.hpp"
#include "verification/studies/holdout.hpp"
#include "verification/studies/macneal_harder.hpp"
#include "verification/studies/manufactured_corotational.hpp"
#include "verification/studies/manufactured_dynamics.hpp"
#include "verification/studies/manufactured_static.hpp"
#include "verification/studies/needle_evidence.hpp"
#include "verification/studies/plane_problems.hpp"
#include "verification/studies/reversibility.hpp"
#include "verification/studies/solid_problems.hpp"
#include "verification/studies/solver_evidence.hpp"
#include "verification/studies/use_errors.hpp"

namespace finegauge {

std::span<const EvidenceStudy> evidence_studies() {
  using enum CredibilityFactor;
  static const std::vector<EvidenceStudy> studies = {
      {"reversibility", software_quality_assurance,
       "random refinement histories: the way back to the last bit, order of operations, T, bounded memory",
       &reversibility_evidence},
      {"determinism", software_quality_assurance, "same bits from run to run and for any number of threads",
       &determinism_evidence},
      {"manufactured-static", code_verification,
       "orders and constants on manufactured solutions: hexahedra, tetrahedra, templates, nu to 0.4999",
       &manufactured_static_evidence},
      {"manufactured-corotational", code_verification,
       "finite rotations: the frozen-rotation operator, and the hyperelastic limit of small strain",
       &manufactured_corotational_evidence},
      {"manufactured-dynamics", code_verification, "orders in time and space of linear tissue in motion",
       &manufactured_dynamics_evidence},
      {"macneal-harder", code_verification, "the patch test and the beams of MacNeal & Harder, with honest scores",
       &macneal_harder_evidence},
      {"plane-problems", code_verification, "Cook's membrane, NAFEMS LE1, Kirsch's hole", &plane_problems_evidence},
      {"solid-problems", code_verification, "thick cylinder and sphere to nu 0.4999, NAFEMS LE10, Boussinesq",
       &solid_problems_evidence},
      {"needle", code_verification, "beams against closed forms, buckling, the force on a line, balance of forces",
       &needle_evidence},
      {"friction", code_verification, "incline, stick-slip, channel, puncture and cut, nothing to touch",
       &friction_evidence},
      {"estimator", discretization_error,
       "the certificate: estimated over true error of three estimators on a ladder of known solutions",
       &estimator_ladder_evidence},
      {"holdout", discretization_error,
       "the certificate on problems that it does not rest on, some of them drawn blind", &holdout_evidence},
      {"solver", numerical_solver_error,
       "residual against true error, contact forces over 16 decades of weight, the oscillator's steps",
       &solver_evidence},
      {"atlas", numerical_solver_error, "extremes an axis at a time: right, refused, or the first that is neither",
       &atlas_evidence},
      {"use-errors", use_error, "mistakes in a scene, and whether each is refused with file, line and field",
       &use_errors_evidence}};
  return studies;
}

}  // namespace finegauge
