#include "core/scene/scene_keys.hpp"

namespace finegauge {
namespace {

constexpr KeyRange any{};
constexpr KeyRange above_zero{.low = 0.0};
constexpr KeyRange not_negative{.low = 0.0, .low_allowed = true};
constexpr KeyRange whole(double low, double high, std::string_view why = {}) {
  return {.low = low, .high = high, .low_allowed = true, .high_allowed = true, .why = why};
}

// Why a key of the other kind of scene is refused.
constexpr std::string_view no_time = "a static scene has no time";
constexpr std::string_view adapts_by_frames = "a moving scene adapts once a frame, by theta, coarsen_below and dwell";
constexpr std::string_view adapts_by_steps =
    "a static scene refines in steps, by marking and theta, and coarsens nothing";
constexpr std::string_view newton_of_steps = "Newton's iteration of a moving scene is that of [dynamics]";

constexpr SceneSection sections[] = {
    {"", false, true, "what the scene is; these keys stand before the first section"},
    {"box", false, false,
     "geometry: a box, or a box without a block of cells; exactly one of [box], [mesh], [gmsh], [organ]"},
    {"mesh", false, false, "geometry: nodes and cells listed here"},
    {"gmsh", false, false, "geometry: a mesh file, gmsh 2.2 or 4.1 in ASCII"},
    {"organ", false, false,
     "geometry: a closed surface immersed in a lattice of cubes, each of which carries the share of it that is "
     "material; "
     "held by [[attachment]]"},
    {"surface", true, false,
     "a named surface beside x_min, x_max, y_min, y_max, z_min, z_max (faces in the planes of the bounding box), "
     "boundary (all), notch (of a removed block) and the physical surfaces of a gmsh file; a plane, or nodes"},
    {"material", false, true, "isotropic elasticity"},
    {"support", true, false, "a surface of known displacement u(X) = displacement + gradient X, X the rest position"},
    {"attachment", true, false,
     "a region that is held, clamped or by springs, and may move: what lies in a box or a sphere, or a patch of the "
     "surface; of any geometry. Clamped are the base nodes in it (patch: those of the cells or faces that it touches) "
     "and "
     "all that lies between them, however it is refined. Springs hold the pieces of the surface (triangles of an "
     "organ, "
     "boundary faces of a mesh) whose centre is in it"},
    {"load", true, false, "exactly one of traction and total_force on a surface, or body_force; several add up"},
    {"refine", true, false, "refinement before the first solve, in the order of the file"},
    {"adapt", false, false,
     "refinement by estimated error. Static: solve, estimate, mark, refine, again. Moving: once a frame, coarsening "
     "where the stress falls"},
    {"solver", false, false, "how the equilibrium, or the step of a moving scene, is solved"},
    {"quantity", true, false, "a quantity of interest"},
    {"dynamics", false, false,
     "makes the scene a moving one: backward Euler from rest, loads constant, supports by their course"},
    {"needle", false, false, "a round elastic needle, straight but for its imperfection; needs [dynamics], [contact]"},
    {"stroke", true, false,
     "how the needle's base moves, one stroke after the other, then it rests: displacement with speed, or a dwell"},
    {"contact", false, false, "what needle and tissue do to each other"},
};

constexpr SceneKey keys[] = {
    {"", "name", KeyType::text, "", any, "", optional_key, "short name, used for result files; none: the file's name"},
    {"", "description", KeyType::text, "", any, "", "\"\"", "what the scene shows and where it comes from"},
    {"", "units", KeyType::choice, "", any, "SI|none", "\"SI\"", "none: dimensionless, units below are proportions"},

    {"box", "origin", KeyType::vector, "m", any, "", "[0, 0, 0]", "lower corner"},
    {"box", "size", KeyType::vector, "m", above_zero, "", required_key, "edge lengths"},
    {"box", "cells", KeyType::integers3, "", whole(1, 4096, "and at most 4,000,000 in all"), "", required_key,
     "cells along each axis"},
    {"box", "shape", KeyType::choice, "", any, "hexahedron|tetrahedron", "\"hexahedron\"",
     "shape of the cells; tetrahedra: six in each cell of the lattice"},
    {"box", "removed_first", KeyType::integers3, "", whole(0, 4096), "", optional_key,
     "first lattice cell of a removed block along each axis, from 0"},
    {"box", "removed_last", KeyType::integers3, "", whole(0, 4096), "", optional_key,
     "lattice cell after the last of the removed block along each axis"},

    {"mesh", "shape", KeyType::choice, "", any, "hexahedron|tetrahedron", "\"hexahedron\"", "shape of all cells"},
    {"mesh", "nodes", KeyType::points, "m", any, "", required_key, "rest positions"},
    {"mesh", "cells", KeyType::index_lists, "", whole(0, 2147483647), "", required_key,
     "corners of each cell by node number from 0, in the order of VTK and gmsh"},

    {"gmsh", "file", KeyType::text, "", any, "", required_key,
     "path, relative to the scene file; first-order hexahedra or tetrahedra"},

    {"organ", "surface", KeyType::text, "", any, "", required_key,
     "path, relative to the scene file, of a closed surface of triangles: STL, OBJ, PLY or gmsh"},
    {"organ", "scale", KeyType::number, "", above_zero, "", "1.0",
     "the file's coordinates times this are metres; 0.001 for millimetres"},
    {"organ", "cell_size", KeyType::number, "m", above_zero, "", required_key, "edge length of the lattice's cubes"},
    {"organ", "origin", KeyType::vector, "m", any, "", optional_key,
     "a corner of the lattice; none: the body is centred in the fewest cells that hold it"},

    {"surface", "name", KeyType::text, "", any, "", required_key, "a name not taken yet"},
    {"surface", "normal", KeyType::direction, "", any, "", optional_key, "of the plane; any length"},
    {"surface", "point", KeyType::vector, "m", any, "", optional_key, "on the plane; needed with normal"},
    {"surface", "tolerance", KeyType::number, "", KeyRange{.low = 0.0, .high = 0.1}, "", "1e-6",
     "distance of the corners from the plane, as a share of the diagonal of the body"},
    {"surface", "nodes", KeyType::index_list, "", whole(0, 2147483647), "", optional_key,
     "of a [mesh]: the boundary faces all of whose corners are listed"},

    {"material", "youngs_modulus", KeyType::number, "Pa", above_zero, "", required_key, "E"},
    {"material", "poisson_ratio", KeyType::number, "",
     KeyRange{.low = -1.0, .high = 0.5, .why = "0.5 is the incompressible limit, where the bulk modulus is infinite"},
     "", required_key, "nu"},
    {"material", "dilatation", KeyType::choice, "", any, "standard|mean", "\"standard\"",
     "mean: volume change averaged over each hexahedron, does not lock as nu nears 0.5"},
    {"material", "kinematics", KeyType::choice, "", any, "linear|corotational", "\"linear\"",
     "corotational: strain measured in a frame that turns with the cell"},

    {"support", "surface", KeyType::text, "", any, "", required_key, "where"},
    {"support", "normal", KeyType::direction, "", any, "", optional_key,
     "hold only the displacement along it: a sliding plane"},
    {"support", "components", KeyType::axes, "", any, "", optional_key,
     "hold only these components; without normal and components all are held"},
    {"support", "displacement", KeyType::vector, "m", any, "", "[0, 0, 0]", "constant part"},
    {"support", "gradient", KeyType::matrix, "", any, "", "[[0, 0, 0], [0, 0, 0], [0, 0, 0]]",
     "linear part: row i, column j is du_i / dX_j"},
    {"support", "course", KeyType::course, "s, 1", any, "", optional_key,
     "factor of the displacement over time, linear between its points; before the first and after the last it stays; "
     "none: 1 at all times",
     KeyScope::moving_only, no_time},
    {"support", "period", KeyType::number, "s", above_zero, "", optional_key,
     "the course repeats, linear from its last point to its first one of the next period", KeyScope::moving_only,
     no_time},

    {"attachment", "name", KeyType::text, "", any, "", required_key, "a name not taken yet"},
    {"attachment", "box_min", KeyType::vector, "m", any, "", optional_key,
     "lower corner of a box, edges included; needs box_max"},
    {"attachment", "box_max", KeyType::vector, "m", any, "", optional_key, "upper corner of the box"},
    {"attachment", "sphere_centre", KeyType::vector, "m", any, "", optional_key, "of a ball; needs sphere_radius"},
    {"attachment", "sphere_radius", KeyType::number, "m", above_zero, "", optional_key, "of the ball"},
    {"attachment", "patch_point", KeyType::vector, "m", any, "", optional_key,
     "near the surface: the patch lies around the surface's nearest point; needs patch_radius"},
    {"attachment", "patch_radius", KeyType::number, "m", above_zero, "", optional_key,
     "pieces of the surface whose centre is so near to the patch's middle belong to it"},
    {"attachment", "hold", KeyType::choice, "", any, "clamped|springs", "\"clamped\"",
     "clamped: goes where it is taken; springs: pulled there"},
    {"attachment", "stiffness", KeyType::number, "N/m^3", above_zero, "", optional_key,
     "of the springs, force per displacement and rest area; needed with hold = \"springs\""},
    {"attachment", "displacement", KeyType::vector, "m", any, "", "[0, 0, 0]",
     "of the region or the springs' anchors, times the course or breathing; of breathing the amplitude, exhale to "
     "inhale"},
    {"attachment", "course", KeyType::course, "s, 1", any, "", optional_key,
     "factor of the displacement over time, as in [[support]]", KeyScope::moving_only, no_time},
    {"attachment", "period", KeyType::number, "s", above_zero, "", optional_key, "the course repeats",
     KeyScope::moving_only, no_time},
    {"attachment", "breathing_period", KeyType::number, "s", above_zero, "", optional_key,
     "in place of a course: breathing, from exhale (0) over inhale (1) back to exhale", KeyScope::moving_only, no_time},
    {"attachment", "breathing_waveform", KeyType::choice, "", any, "sine|cos4", "\"sine\"",
     "sine: sin^2(pi t/T), as long in as out; cos4: cos^4(pi t/T - pi/2), rests at exhale (Lujan 1999)",
     KeyScope::moving_only, no_time},
    {"attachment", "breathing_ramp", KeyType::number, "s", not_negative, "", optional_key,
     "breathing grows to its full amplitude so long, without a jump of acceleration; 0: at once; none: a period",
     KeyScope::moving_only, no_time},

    {"load", "surface", KeyType::text, "", any, "", optional_key, "where; needed with traction and total_force"},
    {"load", "traction", KeyType::vector, "Pa", any, "", optional_key, "force per rest area"},
    {"load", "total_force", KeyType::vector, "N", any, "", optional_key, "force on the whole surface"},
    {"load", "share", KeyType::choice, "", any, "area|node", "\"area\"",
     "of a total force: by area, or an equal part to each node"},
    {"load", "body_force", KeyType::vector, "N/m^3", any, "", optional_key, "on the whole body; takes no surface"},

    {"refine", "all", KeyType::boolean, "", any, "", "false", "every cell; else those whose centre is in a region"},
    {"refine", "min", KeyType::vector, "m", any, "", optional_key, "lower corner of the region"},
    {"refine", "max", KeyType::vector, "m", any, "", optional_key, "upper corner of the region"},
    {"refine", "template", KeyType::refinement, "", any, "", "\"2x2x2\"", "children along each of the cell's own axes"},
    {"refine", "levels", KeyType::integer, "", whole(1, 20), "", "1", "times over"},

    {"adapt", "steps", KeyType::integer, "", whole(0, 1000), "", required_key, "refinements at most",
     KeyScope::static_only, adapts_by_frames},
    {"adapt", "marking", KeyType::choice, "", any, "maximum|bulk|fraction|threshold", "\"maximum\"",
     "cells with eta_e >= theta max; the fewest with theta^2 of sum eta_e^2; the theta largest; eta_e > threshold",
     KeyScope::static_only, adapts_by_frames},
    {"adapt", "theta", KeyType::number, "", KeyRange{.low = 0.0, .high = 1.0, .high_allowed = true}, "", "0.3",
     "of maximum, bulk and fraction; moving: refine where eta_e >= theta max and the stress rises"},
    {"adapt", "threshold", KeyType::number, "J^0.5", above_zero, "", optional_key,
     "needed with marking = \"threshold\"", KeyScope::static_only, adapts_by_frames},
    {"adapt", "coarsen_below", KeyType::number, "",
     KeyRange{.low = 0.0, .high = 1.0, .low_allowed = true, .why = "and below theta, or the mesh would chatter"}, "",
     "0.05", "coarsen a family whose error is at most this times max eta_e, where the stress falls",
     KeyScope::moving_only, adapts_by_steps},
    {"adapt", "local_tolerance", KeyType::number, "", KeyRange{.low = 0.0, .high = 1.0, .low_allowed = true}, "", "0.0",
     "of the largest eta_e over the body's energy norm, held as tolerance is; 0: not asked", KeyScope::moving_only,
     adapts_by_steps},
    {"adapt", "refine_at", KeyType::number, "", KeyRange{.low = 0.0, .high = 1.0, .high_allowed = true}, "", "0.9",
     "share of a tolerance at which refinement sets in, before it is a miss", KeyScope::moving_only, adapts_by_steps},
    {"adapt", "coarsen_at", KeyType::number, "",
     KeyRange{.low = 0.0, .high = 1.0, .low_allowed = true, .why = "and below refine_at, or the mesh would chatter"},
     "", "0.7",
     "share of a tolerance that the error predicted after a coarsening may have; nearer to refine_at: fewer cells, "
     "more changes",
     KeyScope::moving_only, adapts_by_steps},
    {"adapt", "energy_floor", KeyType::number, "J", KeyRange{.low = 0.0, .low_allowed = true}, "", "0.0",
     "a body with less energy (integral of strain : stress) is at rest and only coarsens", KeyScope::moving_only,
     adapts_by_steps},
    {"adapt", "dwell", KeyType::integer, "frames", whole(0, 1000000), "", "10", "for which a new cell stays",
     KeyScope::moving_only, adapts_by_steps},
    {"adapt", "every", KeyType::integer, "frames", whole(1, 1000000), "", "1", "between two markings",
     KeyScope::moving_only, adapts_by_steps},
    {"adapt", "release", KeyType::integer, "frames", whole(0, 1000000), "", "10",
     "over which the forces go to those of a new mesh, in equal parts; 0 or 1: all in the next frame",
     KeyScope::moving_only, adapts_by_steps},
    {"adapt", "check_popping", KeyType::boolean, "", any, "", "false",
     "follow the force after each change of the mesh on the old and on the new one, and compare with their "
     "equilibria: slow, changes no result",
     KeyScope::moving_only, adapts_by_steps},
    {"adapt", "enabled", KeyType::boolean, "", any, "", "true",
     "false: the mesh stays as it is, as if the section were not there; to compare by --set"},
    {"adapt", "policy", KeyType::choice, "", any, "template|directional", "\"template\"",
     "directional: the cheapest template that reduces the cell's error where it is"},
    {"adapt", "template", KeyType::refinement, "", any, "", "\"2x2x2\"", "of policy = \"template\""},
    {"adapt", "tolerance", KeyType::number, "", KeyRange{.low = 0.0, .high = 1.0, .low_allowed = true}, "", "0.0",
     "of the relative estimated error eta; static: stop when it is met; moving: refine until it is met or max_depth is "
     "reached, whatever the stress does, and coarsen where it is over-met; 0: not asked"},
    {"adapt", "max_depth", KeyType::integer, "", whole(0, 20), "", "20", "cells that were refined so often are left",
     KeyScope::always, "", "1"},
    {"adapt", "max_dofs", KeyType::integer, "", whole(1, 2147483647), "", "2000000",
     "no further refinement from this many degrees of freedom on"},
    {"adapt", "estimator", KeyType::choice, "", any, "spr|spr_edges", "\"spr_edges\"",
     "superconvergent patch recovery as the paper has it, or with cells at singular edges of the body (notches, rims "
     "of "
     "clamped faces) weighted by what it misses there; scenes without [adapt] take the latter"},

    {"solver", "method", KeyType::choice, "", any, "automatic|direct|multigrid", "\"automatic\"",
     "sparse Cholesky, or conjugate gradients with multigrid", KeyScope::static_only,
     "a moving scene's choice is step_method"},
    {"solver", "step_method", KeyType::choice, "", any, "kept|plain", "\"kept\"",
     "conjugate gradients, preconditioned by a Cholesky factor that is kept while it serves, or without preconditioner",
     KeyScope::moving_only, "a static scene's choice is method"},
    {"solver", "relative_residual", KeyType::number, "",
     KeyRange{.low = 1e-14, .high = 1.0, .low_allowed = true, .why = "rounding allows no less than 1e-14"}, "", "1e-6",
     "of each linear solve: |b - A x| / |b|", KeyScope::always, "", "1e-9"},
    {"solver", "iterations", KeyType::integer, "", whole(1, 1000000), "", "1000", "of each linear solve at most",
     KeyScope::always, "", "2000"},
    {"solver", "newton_iterations", KeyType::integer, "", whole(1, 10000), "", "50", "at most, corotational only",
     KeyScope::static_only, newton_of_steps},
    {"solver", "newton_residual", KeyType::number, "",
     KeyRange{.low = 1e-14, .high = 1.0, .low_allowed = true, .why = "rounding allows no less than 1e-14"}, "", "1e-8",
     "force out of balance over the force applied, corotational only", KeyScope::static_only, newton_of_steps},

    {"quantity", "kind", KeyType::choice, "", any, "energy|displacement|tip_force|force_curve", required_key,
     "twice the strain energy, the integral of strain : stress [J]; a displacement [m]; the axial force of the "
     "needle's tip [N]; the curve of the needle's force over the travel of its tip"},
    {"quantity", "name", KeyType::text, "", any, "", optional_key, "of the result; none: the kind"},
    {"quantity", "point", KeyType::vector, "m", any, "", optional_key,
     "rest position of the material point, in one of the cells; needed with displacement"},

    {"dynamics", "time_step", KeyType::number, "s", above_zero, "", required_key, "length of a frame"},
    {"dynamics", "duration", KeyType::number, "s", above_zero, "", optional_key,
     "at least a time step; none: that of all strokes, required where there are none"},
    {"dynamics", "density", KeyType::number, "kg/m^3", above_zero, "", required_key, "of the body, at rest"},
    {"dynamics", "mass_damping", KeyType::number, "1/s", not_negative, "", "0.0",
     "Rayleigh's alpha in C = alpha M + beta K"},
    {"dynamics", "stiffness_damping", KeyType::number, "s", not_negative, "", "0.0", "Rayleigh's beta"},
    {"dynamics", "gravity", KeyType::vector, "m/s^2", any, "", "[0, 0, 0]", "acts on the body, not on the needle"},
    {"dynamics", "newton_iterations", KeyType::integer, "", whole(1, 100), "", "1",
     "of each step; 1: one linear solve, whose error is reported as equilibrium_error"},
    {"dynamics", "newton_residual", KeyType::number, "",
     KeyRange{.low = 1e-14, .high = 1.0, .low_allowed = true, .why = "rounding allows no less than 1e-14"}, "", "1e-9",
     "equilibrium_error at which Newton's iteration stops"},
    {"dynamics", "estimate_error", KeyType::boolean, "", any, "", "true", "in every frame; [adapt] needs it"},
    {"dynamics", "deadline", KeyType::number, "ms", above_zero, "", optional_key,
     "wall time of a frame that counts as missed above it; milliseconds, whatever the scene's units"},

    {"needle", "youngs_modulus", KeyType::number, "Pa", above_zero, "", required_key, "E"},
    {"needle", "poisson_ratio", KeyType::number, "", KeyRange{.low = -1.0, .high = 0.5}, "", required_key, "nu"},
    {"needle", "radius", KeyType::number, "m", above_zero, "", required_key, "of the round, solid section"},
    {"needle", "density", KeyType::number, "kg/m^3", above_zero, "", required_key,
     "of the needle's material; gives its inertia, gravity acts on the body alone"},
    {"needle", "base", KeyType::vector, "m", any, "", required_key, "where it is held, at the start; outside the body"},
    {"needle", "tip", KeyType::vector, "m", any, "", required_key, "at the start; outside the body"},
    {"needle", "elements", KeyType::integer, "", whole(1, 10000), "", "16", "beam elements of equal length"},
    {"needle", "base_rotation", KeyType::choice, "", any, "fixed|free", "\"fixed\"", "whether the base may turn"},
    {"needle", "guided", KeyType::boolean, "", any, "", "true",
     "what is outside the body is held across the axis, as by a sheath; else a slender needle may buckle"},
    {"needle", "imperfection", KeyType::number, "m", not_negative, "", "0.0",
     "lateral offset of the tip at rest, growing with the square of the distance from the base"},
    {"needle", "imperfection_direction", KeyType::direction, "", any, "", optional_key,
     "of which the part across the needle counts; needed with imperfection"},

    {"stroke", "displacement", KeyType::vector, "m", any, "", optional_key, "of the base; needs speed"},
    {"stroke", "speed", KeyType::number, "m/s", above_zero, "", optional_key, "of the base"},
    {"stroke", "dwell", KeyType::number, "s", above_zero, "", optional_key, "the base rests so long"},

    {"contact", "puncture_strength", KeyType::number, "N", not_negative, "", required_key,
     "axial force of the tip at which the surface gives way"},
    {"contact", "cut_strength", KeyType::number, "N", not_negative, "", optional_key,
     "axial force at which the tip cuts on inside; none: puncture_strength"},
    {"contact", "cut_advance", KeyType::number, "m", above_zero, "", required_key,
     "advance of the tip in one cut, and spacing of the contact points left along the path; at most the needle's "
     "length"},
    {"contact", "friction", KeyType::number, "", not_negative, "", required_key,
     "Coulomb's coefficient of the shaft against advance; of the tip's cutting law, too"},
    {"contact", "friction_out", KeyType::number, "", not_negative, "", optional_key,
     "of the shaft against withdrawal; none: friction"},
    {"contact", "surface_friction", KeyType::number, "", not_negative, "", "0.0",
     "of the tip on the surface before puncture"},
    {"contact", "clamping", KeyType::number, "N/m", not_negative, "", "0.0",
     "force with which the tissue holds the shaft, per length: friction without lateral load"},
    {"contact", "coupling_radius", KeyType::number, "m", not_negative, "", optional_key,
     "radius over which contact forces are spread; 0: points, without a limit as the mesh is refined; none: the "
     "needle's radius"},
    {"contact", "weight", KeyType::number, "", above_zero, "", "10000.0",
     "of the augmented Lagrangian, over the stiffness that a constraint meets"},
    {"contact", "tolerance", KeyType::number, "",
     KeyRange{.low = 1e-14, .high = 1.0, .low_allowed = true, .why = "rounding allows no less than 1e-14"}, "", "1e-8",
     "of the violation over the fastest speed of the base, and of the multipliers' change"},
    {"contact", "iterations", KeyType::integer, "", whole(1, 1000000), "", "100", "of Uzawa at most"},
};

}  // namespace

std::span<const SceneSection> scene_sections() { return sections; }
std::span<const SceneKey> scene_keys() { return keys; }

}  // namespace finegauge
