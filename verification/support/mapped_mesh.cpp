#include "verification/support/mapped_mesh.hpp"

#include <sstream>
#include <stdexcept>
#include <utility>

namespace finegauge {

BaseMesh mapped(BaseMesh mesh, const Mapping& mapping) {
  for (Eigen::Index node = 0; node < mesh.nodes.cols(); ++node)
    mesh.nodes.col(node) = mapping(Eigen::Vector3d(mesh.nodes.col(node)));
  return mesh;
}

BaseMesh mapped_box(const std::array<int, 3>& cells, const Mapping& mapping) {
  BoxMeshOptions options;
  options.cells = cells;
  return mapped(box_mesh(options), mapping);
}

int node_at(const Eigen::Matrix3Xd& nodes, const Eigen::Vector3d& X) {
  Eigen::Index nearest = 0;
  const double distance = (nodes.colwise() - X).colwise().norm().minCoeff(&nearest);
  const double diagonal = (nodes.rowwise().maxCoeff() - nodes.rowwise().minCoeff()).norm();
  if (!(distance <= 1e-9 * diagonal)) {
    std::ostringstream message;
    message << "no node at (" << X.transpose() << "): the nearest is " << distance << " away";
    throw std::invalid_argument(message.str());
  }
  return static_cast<int>(nearest);
}

}  // namespace finegauge
