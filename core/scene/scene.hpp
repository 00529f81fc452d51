#pragma once

#include <Eigen/Core>
#include <array>
#include <limits>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "core/adapt/error_estimate.hpp"
#include "core/elasticity/material.hpp"
#include "core/equilibrium.hpp"
#include "core/insertion_frame.hpp"
#include "core/mesh/base_mesh.hpp"
#include "core/mesh/refinement_template.hpp"
#include "core/mesh/region.hpp"
#include "core/scene/course.hpp"
#include "core/space/loads.hpp"
#include "core/space/springs.hpp"
#include "core/space/supports.hpp"

namespace finegauge {

/// A surface that the scene names itself: the boundary faces in a plane, or those whose corners are all listed.
struct SurfaceDefinition {
  std::string name;
  Eigen::Vector3d normal = Eigen::Vector3d::Zero();  ///< of the plane, any length; zero: the surface is a list of nodes
  Eigen::Vector3d point = Eigen::Vector3d::Zero();   ///< on the plane [m]
  double tolerance = 0.0;                            ///< distance from the plane over the diagonal of the body
  std::vector<int> nodes;                            ///< of the base mesh
};

/// A prescribed displacement u(X) = displacement + gradient X of the rest position X, times the course's factor.
struct SceneSupport {
  std::string surface;
  std::optional<Eigen::Vector3d> normal;                   ///< hold only the component along it
  std::vector<int> components;                             ///< or hold only these axes, 0 to 2; both empty: hold all
  Eigen::Vector3d displacement = Eigen::Vector3d::Zero();  ///< [m]
  Eigen::Matrix3d gradient = Eigen::Matrix3d::Zero();      ///< du_i / dX_j
  std::optional<Course> course;                            ///< of moving scenes
};

/// A part of the body that is held at its rest position, or displaced from it by displacement × course.
struct SceneAttachment {
  std::string name;  ///< of the region, in messages and results
  Selection where;
  double stiffness = 0.0;  ///< of springs per rest area of the selected surface [N/m³]; 0: clamped, no springs
  Eigen::Vector3d displacement = Eigen::Vector3d::Zero();  ///< [m]
  std::optional<Course> course;                            ///< of moving scenes
};

/// Leaves whose centre lies in the box are refined, `levels` times over.
struct InitialRefinement {
  Eigen::Vector3d min = Eigen::Vector3d::Constant(-std::numeric_limits<double>::infinity());  ///< [m]
  Eigen::Vector3d max = Eigen::Vector3d::Constant(std::numeric_limits<double>::infinity());   ///< [m]
  RefinementTemplate refinement;
  int levels = 1;
};

enum class Marking { maximum, bulk, fraction, threshold };
enum class RefinementPolicy { one_template, directional };

/// How a static problem is refined: solve, estimate, mark, refine, again.
struct AdaptRules {
  int steps = 0;  ///< refinements at most
  Marking marking = Marking::maximum;
  double theta = 0.3;      ///< of the maximum, bulk and fraction strategies
  double threshold = 0.0;  ///< of the threshold strategy: error of a cell [√J]
  RefinementPolicy policy = RefinementPolicy::one_template;
  RefinementTemplate refinement;
  double tolerance = 0.0;  ///< stop at a relative estimated error η of at most this
  int max_depth = 0;       ///< a leaf this deep is not refined
  int max_dofs = 0;        ///< no further step from this many dofs on
};

/// What makes a scene a moving one.
struct SceneDynamics {
  double time_step = 0.0;                              ///< [s]
  double duration = 0.0;                               ///< [s], at least a time step
  double density = 0.0;                                ///< [kg/m³]
  double mass_damping = 0.0, stiffness_damping = 0.0;  ///< Rayleigh's α [1/s] and β [s]
  Eigen::Vector3d gravity = Eigen::Vector3d::Zero();   ///< [m/s²]
  TissueStepOptions step;
  StepSolverOptions solver;
  bool estimate_error = true;
  std::optional<FrameAdaptRules> adapt;
  bool check_popping = false;         ///< compare the force after each change of the mesh with its equilibrium's
  std::optional<double> deadline_ms;  ///< of a frame
};

/// A needle, how it is moved, and what it does to the tissue.
struct SceneNeedle {
  NeedleProperties properties;
  Eigen::Vector3d base = Eigen::Vector3d::Zero(), tip = Eigen::Vector3d::Zero();  ///< at the start [m]
  int elements = 1;
  double imperfection = 0.0;                                         ///< lateral offset of the tip at rest [m]
  Eigen::Vector3d imperfection_direction = Eigen::Vector3d::Zero();  ///< unit, across the needle; zero without one
  NeedleDrive drive;
  ContactRules contact;
  InteractionOptions interaction;
};

enum class QuantityKind { energy, displacement, tip_force, force_curve };

/// A number that the scene is about.
struct QuantityOfInterest {
  std::string name;
  QuantityKind kind = QuantityKind::energy;
  Eigen::Vector3d point = Eigen::Vector3d::Zero();  ///< material point [m], of a displacement
};

/// What the problem is. Read once, never changed. A section that the scene lacks is an empty list or optional.
struct Scene {
  std::string file;      ///< where it came from, for messages
  int support_line = 1;  ///< of the first [[support]] or, without one, [[attachment]]; for messages
  std::string name, description;
  bool dimensionless = false;      ///< units in the key table are then only proportions
  std::vector<std::string> notes;  ///< what was mended when a surface was read, for the program to print
  std::variant<BoxMeshOptions, BaseMesh> geometry;
  std::vector<SurfaceDefinition> surfaces;
  Material material;
  std::vector<SceneSupport> supports;
  std::vector<SceneAttachment> attachments;
  std::vector<SurfaceLoad> loads;
  Eigen::Vector3d body_force = Eigen::Vector3d::Zero();  ///< [N/m³]
  std::vector<InitialRefinement> refinements;
  Estimator estimator = Estimator::spr_edges;
  std::optional<AdaptRules> adapt;  ///< of a static scene
  EquilibriumOptions solver;        ///< of a static scene
  std::optional<SceneDynamics> dynamics;
  std::optional<SceneNeedle> needle;  ///< only with dynamics
  std::vector<QuantityOfInterest> quantities;
};

/// The base mesh with all named surfaces: those of the geometry, `boundary` (all of it), x_min ... z_max (the faces in
/// the planes of the bounding box, unless the mesh file names them itself), and the scene's own. An immersed body has
/// none of them, since the faces of its cells are not its surface. Clamped attachments are its regions.
BaseMesh base_mesh(const Scene& scene);

/// Conditions in the order of the scene, supports before clamped attachments; a support of some components becomes one
/// condition for each.
std::vector<SupportCondition> support_conditions(const Scene& scene);

/// Springs of the attachments that have some, in the order of the scene: stiffness times area at quadrature points of
/// the selected surface.
std::vector<SpringSupport> spring_supports(const Scene& scene);

/// Empty when the scene has no body force.
BodyForce body_force(const Scene& scene);

/// Boundary faces of the definition, ascending; may be empty.
std::vector<BaseFace> select_faces(const BaseMesh& mesh, const SurfaceDefinition& definition);

}  // namespace finegauge
