#include <Eigen/Geometry>
#include <map>
#include <numbers>
#include <utility>

#include "core/scene/surface_check.hpp"
#include "core/scene/surface_reader.hpp"
#include "verification/support/catch.hpp"
#include "verification/support/surface_samples.hpp"
#include "verification/support/temporary_file.hpp"

using namespace finegauge;

TEST_CASE("the liver that ships is one closed body of 1500 cm³ without a handle, meshed evenly", "[surface][liver]") {
  const CheckedSurface checked = check_surface(read_surface(reference_data() / "surfaces" / "liver.obj"), "liver.obj");
  const TriangleSurface& liver = checked.surface;
  CHECK(checked.notes.empty());
  CHECK(liver.triangles.size() >= 3000);
  CHECK(liver.triangles.size() <= 5000);

  // Coordinates are written to 1e-7 m; a vertex counts for a third of its triangles' area, and the errors are unlike.
  CHECK(std::abs(volume_by_divergence(liver) - 1.5e-3) < 1e-7 * 0.075 / 10.0);
  const Eigen::Vector3d size = liver.vertices.rowwise().maxCoeff() - liver.vertices.rowwise().minCoeff();
  CHECK(size.x() == Approx(0.215).epsilon(0.02));
  CHECK(size.y() == Approx(0.132).epsilon(0.02));
  CHECK(size.z() == Approx(0.154).epsilon(0.02));

  std::map<std::pair<int, int>, int> edges;
  double smallest_angle = std::numbers::pi, shortest = 1.0, longest = 0.0;
  Eigen::Vector3d centre = Eigen::Vector3d::Zero();
  for (const auto& corners : liver.triangles) {
    const auto at = [&](std::size_t k) -> Eigen::Vector3d { return liver.vertices.col(corners[k % 3]); };
    centre += at(0).dot(at(1).cross(at(2))) / 24.0 * (at(0) + at(1) + at(2)) / 1.5e-3;
    for (std::size_t k = 0; k < 3; ++k) {
      ++edges[std::minmax(corners[k], corners[(k + 1) % 3])];
      const Eigen::Vector3d side = at(k + 1) - at(k), other = at(k + 2) - at(k);
      smallest_angle = std::min(smallest_angle, std::acos(side.normalized().dot(other.normalized())));
      shortest = std::min(shortest, side.norm());
      longest = std::max(longest, side.norm());
    }
  }
  const auto euler = static_cast<int>(liver.vertices.cols()) - static_cast<int>(edges.size()) +
                     static_cast<int>(liver.triangles.size());
  CHECK(euler == 2);
  CHECK(centre.norm() < 1e-7);
  CHECK(smallest_angle > 29.9 / 180.0 * std::numbers::pi);  // the mesher was asked for 30 degrees
  CHECK(shortest > 2e-3);
  CHECK(longest < 12e-3);
}
