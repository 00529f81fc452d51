#include "core/space/supports.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>

#include "core/mesh/refinement_forest.hpp"
#include "verification/support/catch.hpp"
#include "verification/support/sample_cells.hpp"

using namespace finegauge;

namespace {

/// A box 2 × 2 × 2 cells with one cell refined, so that nodes hang, some of them on supported surfaces.
struct Body {
  BaseMesh base;
  BaseTopology topology;
  Mesh mesh;
  HangingNodes hanging;

  explicit Body(const Eigen::Matrix3d& turn = Eigen::Matrix3d::Identity()) {
    BoxMeshOptions options;
    options.cells = {2, 2, 2};
    base = box_mesh(options);
    base.nodes = turn * base.nodes;
    RefinementForest forest(base);
    topology = forest.topology();
    forest.refine(0, {{2, 2, 2}});
    mesh = forest.leaf_mesh();
    hanging = find_hanging_nodes(forest, mesh);
  }
  Supports find(const std::vector<SupportCondition>& conditions) const {
    return find_supports(base, mesh, hanging, conditions);
  }
  int free_motions(const std::vector<SupportCondition>& conditions) const { return motions_left(find(conditions)); }
  int motions_left(const Supports& supports) const {
    const std::vector<BodyFreedom> bodies = free_rigid_motions(topology, mesh, hanging, supports);
    REQUIRE(bodies.size() == 1);
    CHECK(bodies[0].cells == mesh.cell_count());
    return bodies[0].free_motions;
  }
  Eigen::Vector3d position(const Supports& supports, int i) const {
    return mesh.nodes.col(hanging.node_of[supports.reduced[i]]);
  }
};

SupportCondition clamp(const std::string& surface) { return {surface, std::nullopt, {}}; }
SupportCondition plane(const std::string& surface, const Eigen::Vector3d& normal) { return {surface, normal, {}}; }

std::function<Eigen::Vector3d(const Eigen::Vector3d&)> constant(const Eigen::Vector3d& value) {
  return [value](const Eigen::Vector3d&) { return value; };
}

void check_is_projector(const Eigen::Matrix3d& H, int directions) {
  CHECK((H - H.transpose()).cwiseAbs().maxCoeff() == 0.0);
  CHECK_THAT((H * H - H).cwiseAbs().maxCoeff(), WithinAbs(0.0, 1e-15));
  CHECK_THAT(H.trace(), WithinAbs(directions, 1e-15));
}

const Eigen::Vector3d ex(1, 0, 0), ey(0, 1, 0), ez(0, 0, 1);

}  // namespace

TEST_CASE("a clamped surface holds its nodes that do not hang, and no others", "[supports]") {
  const Body body;
  const auto field = [](const Eigen::Vector3d& X) { return Eigen::Vector3d(X.y(), X.z() * X.z(), 1.0); };
  const Supports supports = body.find({{"x_min", std::nullopt, field}});
  int expected = 0, hanging_there = 0;
  for (int node = 0; node < body.mesh.node_count(); ++node) {
    if (body.mesh.nodes(0, node) != 0.0) continue;
    ++(body.hanging.hangs(node) ? hanging_there : expected);
  }
  REQUIRE(hanging_there > 0);
  REQUIRE(int(supports.reduced.size()) == expected);
  CHECK(std::is_sorted(supports.reduced.begin(), supports.reduced.end()));
  for (int i = 0; i < expected; ++i) {
    CHECK(body.position(supports, i).x() == 0.0);
    CHECK(supports.held[i] == Eigen::Matrix3d::Identity());
    CHECK(supports.displacement[i] == field(body.position(supports, i)));
  }
}

TEST_CASE("a hanging node of a supported surface hangs on supported nodes", "[supports][hanging]") {
  const Body body;
  const Supports supports = body.find({clamp("x_min")});
  int seen = 0;
  for (int node = 0; node < body.mesh.node_count(); ++node) {
    if (!body.hanging.hangs(node) || body.mesh.nodes(0, node) != 0.0) continue;
    ++seen;
    for (int k = body.hanging.row_start[node]; k < body.hanging.row_start[node + 1]; ++k)
      CHECK(std::binary_search(supports.reduced.begin(), supports.reduced.end(), body.hanging.master[k]));
  }
  CHECK(seen > 0);
}

TEST_CASE("a component along an axis holds that axis exactly", "[supports]") {
  const Body body;
  const Supports supports = body.find({{"z_max", Eigen::Vector3d(0, 0, -3e-7), constant({7.0, 8.0, 0.5})}});
  for (std::size_t i = 0; i < supports.reduced.size(); ++i) {
    CHECK(supports.held[i] == Eigen::Matrix3d(ez.asDiagonal()));
    CHECK(supports.displacement[i] == Eigen::Vector3d(0.0, 0.0, 0.5));
  }
}

TEST_CASE("conditions meet on the edges and corners of the surfaces", "[supports]") {
  const Body body;
  const Supports supports = body.find({{"x_min", ex, constant({0.1, 9, 9})},
                                       {"y_min", ey, constant({9, 0.2, 9})},
                                       {"z_min", ez, constant({9, 9, 0.3})}});
  std::array<int, 4> count{};
  for (std::size_t i = 0; i < supports.reduced.size(); ++i) {
    const Eigen::Vector3d X = body.position(supports, int(i));
    const Eigen::Vector3d on = (X.array() == 0.0).cast<double>();
    CHECK(supports.held[i] == Eigen::Matrix3d(on.asDiagonal()));
    CHECK(supports.displacement[i] == Eigen::Vector3d(on.cwiseProduct(Eigen::Vector3d(0.1, 0.2, 0.3))));
    ++count[int(on.sum())];
  }
  CHECK(count[0] == 0);
  CHECK(count[1] > 0);
  CHECK(count[2] > 0);
  CHECK(count[3] == 1);
}

TEST_CASE("oblique planes that meet are all met", "[supports]") {
  std::mt19937 generator(61);
  const Body body;
  for (int trial = 0; trial < 20; ++trial) {
    const Eigen::Vector3d n1 = random_vector(generator), n2 = random_vector(generator);
    const Eigen::Vector3d u1 = random_vector(generator), u2 = random_vector(generator);
    const Supports supports = body.find({{"x_min", n1, constant(u1)}, {"y_min", n2, constant(u2)}});
    int edge = 0;
    for (std::size_t i = 0; i < supports.reduced.size(); ++i) {
      const Eigen::Vector3d X = body.position(supports, int(i));
      const bool first = X.x() == 0.0, second = X.y() == 0.0;
      check_is_projector(supports.held[i], int(first) + int(second));
      CHECK_THAT((supports.held[i] * supports.displacement[i] - supports.displacement[i]).norm(),
                 WithinAbs(0.0, 1e-12));
      const double tolerance = 1e-13 / n1.normalized().cross(n2.normalized()).norm();
      if (first) CHECK_THAT(n1.normalized().dot(supports.displacement[i] - u1), WithinAbs(0.0, tolerance));
      if (second) CHECK_THAT(n2.normalized().dot(supports.displacement[i] - u2), WithinAbs(0.0, tolerance));
      edge += first && second;
    }
    CHECK(edge > 0);
  }
}

TEST_CASE("a body turned with its supports is held alike", "[supports][objectivity]") {
  std::mt19937 generator(62);
  const Eigen::Matrix3d turn = turn_about_random_axis(1.1, generator);
  const Eigen::Vector3d n(1.0, 2.0, 0.0), u(0.1, 0.2, 0.3);
  const Supports straight = Body().find({{"x_min", n, constant(u)}, {"y_min", std::nullopt, constant(u)}});
  const Supports turned =
      Body(turn).find({{"x_min", turn * n, constant(turn * u)}, {"y_min", std::nullopt, constant(turn * u)}});
  REQUIRE(straight.reduced == turned.reduced);
  for (std::size_t i = 0; i < straight.reduced.size(); ++i) {
    CHECK_THAT((turned.held[i] - turn * straight.held[i] * turn.transpose()).norm(), WithinAbs(0.0, 1e-14));
    CHECK_THAT((turned.displacement[i] - turn * straight.displacement[i]).norm(), WithinAbs(0.0, 1e-14));
  }
}

TEST_CASE("where conditions contradict each other the first one wins in its directions", "[supports]") {
  const Body body;
  const auto on_edge = [&](const Supports& supports) {
    for (std::size_t i = 0; i < supports.reduced.size(); ++i) {
      const Eigen::Vector3d X = body.position(supports, int(i));
      if (X.x() == 0.0 && X.y() == 0.0) return supports.displacement[i];
    }
    throw std::logic_error("no node on the edge");
  };
  const SupportCondition roller{"x_min", ex, constant({1, 2, 3})}, fixed{"y_min", std::nullopt, constant({4, 5, 6})};
  CHECK(on_edge(body.find({roller, fixed})) == Eigen::Vector3d(1, 5, 6));
  CHECK(on_edge(body.find({fixed, roller})) == Eigen::Vector3d(4, 5, 6));
  const SupportCondition same_plane{"y_min", ex, constant({8, 8, 8})};
  CHECK(on_edge(body.find({roller, same_plane})) == Eigen::Vector3d(1, 0, 0));
}

TEST_CASE("rigid motions that supports leave free are counted", "[supports]") {
  const Body body;
  CHECK(body.free_motions({}) == 6);
  CHECK(body.free_motions({clamp("x_min")}) == 0);
  CHECK(body.free_motions({plane("x_min", ex)}) == 3);
  CHECK(body.free_motions({plane("x_min", ex), plane("x_max", ex)}) == 3);
  CHECK(body.free_motions({plane("x_min", ex), plane("y_min", ey)}) == 1);
  CHECK(body.free_motions({plane("x_min", ex), plane("y_min", ey), plane("z_min", ez)}) == 0);
  CHECK(body.free_motions({plane("x_min", ex), plane("x_min", ey)}) == 1);
  CHECK(body.free_motions({plane("x_min", ex + ey), plane("x_max", ex - ey), plane("y_max", ez)}) == 0);
}

TEST_CASE("rigid motions are counted alike at any place, size and turn", "[supports]") {
  std::mt19937 generator(63);
  const double size = GENERATE(1e-4, 1.0, 1e4);
  const double far_away = GENERATE(0.0, 100.0);
  CAPTURE(size, far_away);
  const Eigen::Matrix3d turn = turn_about_random_axis(0.8, generator);
  Body body(size * turn);
  body.mesh.nodes.colwise() += Eigen::Vector3d::Constant(far_away * size).eval();
  CHECK(body.free_motions({plane("x_min", turn * ex), plane("y_min", turn * ey)}) == 1);
  CHECK(body.free_motions({plane("x_min", turn * ex)}) == 3);
  CHECK(body.free_motions({clamp("z_max")}) == 0);
}

TEST_CASE("supports at one node or on one line leave the rotations about it", "[supports]") {
  const Body body;
  Supports supports;
  const auto hold = [&](const Eigen::Vector3d& at) {
    for (int reduced = 0; reduced < body.hanging.reduced_count(); ++reduced) {
      if (body.mesh.nodes.col(body.hanging.node_of[reduced]) != at) continue;
      supports.reduced.push_back(reduced);
      supports.held.push_back(Eigen::Matrix3d::Identity());
      supports.displacement.push_back(Eigen::Vector3d::Zero());
    }
  };
  hold({0, 0, 0});
  CHECK(body.motions_left(supports) == 3);
  hold({1, 1, 1});
  CHECK(body.motions_left(supports) == 1);
  hold({1, 0, 0});
  CHECK(body.motions_left(supports) == 0);
  REQUIRE(supports.reduced.size() == 3);
}

TEST_CASE("bodies that share no face are held each by itself", "[supports][hanging]") {
  // Boxes of one base cell from x = 0 and from x = 1 on, joined at so many nodes: apart, at a node, an edge, a face.
  const int joints = GENERATE(0, 1, 2, 4);
  const CellShape shape = GENERATE(CellShape::hexahedron, CellShape::tetrahedron);
  CAPTURE(joints, int(shape));
  BoxMeshOptions options;
  options.shape = shape;
  BaseMesh base = box_mesh(options);
  const int cells = int(base.cells.size()), nodes = int(base.nodes.cols());
  // Of the second box the nodes at its lower end take the place of those at the first one's upper end.
  std::vector<int> second(nodes);
  std::vector<Eigen::Vector3d> all;
  for (int i = 0; i < nodes; ++i) all.push_back(base.nodes.col(i));
  int joined = 0;
  for (int i = 0; i < nodes; ++i) {
    // Apart from the joint the boxes are bent away from each other, so that no two nodes lie at one place.
    const Eigen::Vector3d there = base.nodes.col(i) + ex;
    const auto same = std::find(all.begin(), all.begin() + nodes, there);
    if (same != all.begin() + nodes && joined < joints) {
      second[i] = int(same - all.begin());
      ++joined;
    } else {
      second[i] = int(all.size());
      all.push_back(there + (joints < 4 ? 0.1 : 0.0) * ex);
    }
  }
  REQUIRE(joined == joints);
  base.nodes.resize(3, int(all.size()));
  for (int i = 0; i < int(all.size()); ++i) base.nodes.col(i) = all[i];
  for (int cell = 0; cell < cells; ++cell) {
    auto corners = base.cells[cell];
    for (int c = 0; c < corner_count(shape); ++c) corners[c] = second[corners[c]];
    base.cells.push_back(corners);
  }
  base.surfaces = {{"first_end", {}}, {"second_end", {}}};
  for (const BaseFace& face : boundary_faces(base)) {
    double lowest = 3.0, highest = 0.0;
    for (int c = 0; c < face_corner_count(shape); ++c) {
      const double x = base.nodes(0, base.cells[face.cell][face_corners(shape, face.face)[c]]);
      lowest = std::min(lowest, x), highest = std::max(highest, x);
    }
    if (highest == 0.0) base.surfaces["first_end"].push_back(face);
    if (lowest >= 2.0) base.surfaces["second_end"].push_back(face);
  }
  REQUIRE(validate(base).empty());
  RefinementForest forest(base);
  forest.refine(cells, {{2, 2, 2}});  // hanging nodes, and the leaves of one base cell are one body
  const Mesh mesh = forest.leaf_mesh();
  const HangingNodes hanging = find_hanging_nodes(forest, mesh);
  const auto bodies_of = [&](const std::vector<SupportCondition>& conditions) {
    return free_rigid_motions(forest.topology(), mesh, hanging, find_supports(base, mesh, hanging, conditions));
  };
  const auto one = bodies_of({clamp("first_end")});
  if (joints == 4) {
    REQUIRE(one.size() == 1);
    CHECK(one[0].cells == mesh.cell_count());
    CHECK(one[0].free_motions == 0);
    return;
  }
  REQUIRE(one.size() == 2);
  CHECK(one[0].cells == cells);
  CHECK(one[1].cells == cells + 7);
  CHECK(one[0].inside.x() < 1.0);
  CHECK(one[1].inside.x() > 1.0);
  CHECK(one[0].free_motions == 0);
  CHECK(one[1].free_motions == 6);
  const auto both = bodies_of({clamp("first_end"), plane("second_end", ex)});
  CHECK(both[0].free_motions == 0);
  CHECK(both[1].free_motions == 3);
  for (const BodyFreedom& body : bodies_of({clamp("first_end"), clamp("second_end")})) CHECK(body.free_motions == 0);
}

TEST_CASE("supports that have no meaning are refused", "[supports]") {
  const Body body;
  const double nan = std::numeric_limits<double>::quiet_NaN();
  CHECK_THROWS_AS(body.find({clamp("top")}), std::invalid_argument);
  CHECK_THROWS_AS(body.find({plane("x_min", {0, 0, 0})}), std::invalid_argument);
  CHECK_THROWS_AS(body.find({plane("x_min", {nan, 0, 1})}), std::invalid_argument);
  CHECK_THROWS_AS(body.find({{"x_min", std::nullopt, constant({0, nan, 0})}}), std::invalid_argument);
}
