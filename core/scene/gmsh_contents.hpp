#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include "core/scene/file_tokens.hpp"

namespace finegauge {

namespace gmsh_type {
constexpr int triangle = 2, quadrangle = 3, tetrahedron = 4, hexahedron = 5;
}

struct GmshNode {
  std::int64_t tag;
  Eigen::Vector3d position;
  std::size_t line;
};

/// A cell or a face.
struct GmshElement {
  std::int64_t tag;
  std::size_t line;
  int type;
  std::array<std::int64_t, 8> nodes;
  std::vector<std::int64_t> groups;  ///< physical surfaces, of a face
};

struct GmshContents {
  std::map<std::int64_t, std::string> surface_names;                    ///< by physical number
  std::map<std::int64_t, std::vector<std::int64_t>> groups_of_surface;  ///< by geometrical surface, 4.1 only
  std::vector<GmshNode> nodes;                                          ///< by ascending tag, each tag once
  std::vector<GmshElement> cells;                                       ///< of one shape
  std::vector<GmshElement> faces;
  std::size_t nodes_line = 0, elements_line = 0;
};

/// All nodes, cells and faces of a gmsh file, ASCII, format 2.2 or 4.1, first order. Throws SceneError "FILE:LINE: ..."
/// for what read_gmsh lists, as far as it shows without knowing what the file is read for.
GmshContents read_gmsh_contents(FileTokens& in);

/// Place in contents.nodes of corner k of an element.
std::size_t gmsh_node(const FileTokens& in, const GmshContents& contents, const GmshElement& element, int k);

}  // namespace finegauge
