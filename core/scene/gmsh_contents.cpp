#include "core/scene/gmsh_contents.hpp"

#include <algorithm>
#include <cstdlib>
#include <utility>

#include "core/scene/text_file.hpp"

namespace finegauge {

using namespace gmsh_type;

namespace {

constexpr std::int64_t most_items = std::int64_t{1} << 30;  // of anything; storage grows with what is really read
constexpr std::int64_t any_tag = std::int64_t{1} << 53;
constexpr std::size_t most_groups = 32;  // of a surface: each of its faces is in all of them

int element_node_count(FileTokens& in, std::int64_t type) {
  switch (type) {
    case 15:
      return 1;
    case 1:
      return 2;
    case triangle:
      return 3;
    case quadrangle:
    case tetrahedron:
      return 4;
    case hexahedron:
      return 8;
    case 6:
      in.fail("element type", "found 6, a prism, allowed hexahedra (5) or tetrahedra (4)");
    case 7:
      in.fail("element type", "found 7, a pyramid, allowed hexahedra (5) or tetrahedra (4)");
    default:
      in.fail("element type", "found " + std::to_string(type) +
                                  ", of higher order or unknown, allowed first order: points (15), lines (1), "
                                  "triangles (2), quadrangles (3), tetrahedra (4), hexahedra (5)");
  }
}

/// Nodes of an element, which is kept when it is a cell or a face.
void read_element_nodes(FileTokens& in, GmshElement element, GmshContents& contents) {
  const int count = element_node_count(in, element.type);
  for (int k = 0; k < count; ++k)
    element.nodes[static_cast<std::size_t>(k)] = in.integer("node of element", 1, any_tag);
  const bool cell = element.type == tetrahedron || element.type == hexahedron;
  const bool face = element.type == triangle || element.type == quadrangle;
  if (cell && !contents.cells.empty() && contents.cells.front().type != element.type)
    in.fail("element " + std::to_string(element.tag), "found hexahedra and tetrahedra mixed, allowed one shape");
  if (cell)
    contents.cells.push_back(std::move(element));
  else if (face)
    contents.faces.push_back(std::move(element));
}

void read_physical_names(FileTokens& in, GmshContents& contents) {
  const std::int64_t count = in.integer("number of physical names", 0, most_items);
  for (std::int64_t i = 0; i < count; ++i) {
    const std::int64_t dimension = in.integer("dimension of physical name", 0, 3);
    const std::int64_t number = in.integer("number of physical name", -any_tag, any_tag);
    std::string name = in.quoted("physical name");
    if (dimension == 2) contents.surface_names[number] = std::move(name);
  }
}

void read_entities(FileTokens& in, GmshContents& contents) {
  std::array<std::int64_t, 4> counts{};
  for (std::int64_t& count : counts) count = in.integer("number of entities", 0, most_items);
  for (int dimension = 0; dimension < 4; ++dimension)
    for (std::int64_t i = 0; i < counts[static_cast<std::size_t>(dimension)]; ++i) {
      const std::int64_t tag = in.integer("entity tag", -any_tag, any_tag);
      for (int k = 0; k < (dimension == 0 ? 3 : 6); ++k) in.number("extent of entity");
      const std::int64_t groups = in.integer("number of physical tags", 0, most_items);
      for (std::int64_t k = 0; k < groups; ++k) {
        const std::int64_t group = in.integer("physical tag", -any_tag, any_tag);
        if (dimension != 2) continue;
        std::vector<std::int64_t>& of_surface = contents.groups_of_surface[tag];
        of_surface.push_back(std::abs(group));
        if (of_surface.size() > most_groups)
          in.fail("physical tag", "found more than " + std::to_string(most_groups) + " of surface " +
                                      std::to_string(tag) + ", allowed as many");
      }
      if (dimension == 0) continue;
      const std::int64_t bounding = in.integer("number of bounding entities", 0, most_items);
      for (std::int64_t k = 0; k < bounding; ++k) in.integer("bounding entity", -any_tag, any_tag);
    }
}

Eigen::Vector3d read_position(FileTokens& in) {
  const double x = in.number("coordinate"), y = in.number("coordinate"), z = in.number("coordinate");
  return {x, y, z};
}

void read_nodes_2(FileTokens& in, GmshContents& contents) {
  const std::int64_t count = in.integer("number of nodes", 1, most_items);
  for (std::int64_t i = 0; i < count; ++i) {
    const std::int64_t tag = in.integer("node tag", 1, any_tag);
    const std::size_t line = in.line();
    contents.nodes.push_back({tag, read_position(in), line});
  }
}

void read_nodes_4(FileTokens& in, GmshContents& contents) {
  const std::int64_t blocks = in.integer("number of node blocks", 1, most_items);
  const std::int64_t total = in.integer("number of nodes", 1, most_items);
  in.integer("smallest node tag", 1, any_tag);
  in.integer("largest node tag", 1, any_tag);
  for (std::int64_t b = 0; b < blocks; ++b) {
    const std::int64_t dimension = in.integer("dimension of entity", 0, 3);
    in.integer("entity tag", -any_tag, any_tag);
    const std::int64_t parametric = in.integer("parametric flag", 0, 1);
    const std::int64_t count = in.integer("number of nodes in block", 0, most_items);
    const std::size_t first = contents.nodes.size();
    for (std::int64_t i = 0; i < count; ++i) {
      const std::int64_t tag = in.integer("node tag", 1, any_tag);
      contents.nodes.push_back({tag, Eigen::Vector3d::Zero(), in.line()});
    }
    for (std::size_t i = first; i < contents.nodes.size(); ++i) {
      contents.nodes[i].position = read_position(in);
      for (std::int64_t k = 0; k < parametric * dimension; ++k) in.number("parametric coordinate");
    }
  }
  if (static_cast<std::int64_t>(contents.nodes.size()) != total)
    in.fail("number of nodes", "found " + std::to_string(contents.nodes.size()) + " in the blocks, allowed the " +
                                   std::to_string(total) + " announced");
}

void read_elements_2(FileTokens& in, GmshContents& contents) {
  const std::int64_t count = in.integer("number of elements", 1, most_items);
  for (std::int64_t i = 0; i < count; ++i) {
    GmshElement element{};
    element.tag = in.integer("element tag", 1, any_tag);
    element.line = in.line();
    element.type = static_cast<int>(in.integer("element type", 1, 1000));
    const std::int64_t tags = in.integer("number of element tags", 0, 1000);
    for (std::int64_t k = 0; k < tags; ++k) {
      const std::int64_t tag = in.integer("tag of element", -any_tag, any_tag);
      if (k == 0 && tag != 0 && (element.type == triangle || element.type == quadrangle))
        element.groups.push_back(std::abs(tag));
    }
    read_element_nodes(in, std::move(element), contents);
  }
}

void read_elements_4(FileTokens& in, GmshContents& contents) {
  const std::int64_t blocks = in.integer("number of element blocks", 1, most_items);
  const std::int64_t total = in.integer("number of elements", 1, most_items);
  in.integer("smallest element tag", 1, any_tag);
  in.integer("largest element tag", 1, any_tag);
  std::int64_t seen = 0;
  for (std::int64_t b = 0; b < blocks; ++b) {
    const std::int64_t dimension = in.integer("dimension of entity", 0, 3);
    const std::int64_t entity = in.integer("entity tag", -any_tag, any_tag);
    const std::int64_t type = in.integer("element type", 1, 1000);
    const std::int64_t count = in.integer("number of elements in block", 0, most_items);
    const auto groups = contents.groups_of_surface.find(entity);
    for (std::int64_t i = 0; i < count; ++i, ++seen) {
      GmshElement element{};
      element.tag = in.integer("element tag", 1, any_tag);
      element.line = in.line();
      element.type = static_cast<int>(type);
      if (dimension == 2 && groups != contents.groups_of_surface.end()) element.groups = groups->second;
      read_element_nodes(in, std::move(element), contents);
    }
  }
  if (seen != total)
    in.fail("number of elements",
            "found " + std::to_string(seen) + " in the blocks, allowed the " + std::to_string(total) + " announced");
}

/// Nodes by ascending tag.
void sort_nodes(const FileTokens& in, std::vector<GmshNode>& nodes) {
  std::sort(nodes.begin(), nodes.end(),
            [](const GmshNode& a, const GmshNode& b) { return std::pair(a.tag, a.line) < std::pair(b.tag, b.line); });
  for (std::size_t i = 1; i < nodes.size(); ++i)
    if (nodes[i].tag == nodes[i - 1].tag)
      in.fail_at(nodes[i].line, "node " + std::to_string(nodes[i].tag), "found twice, allowed once");
}

}  // namespace

GmshContents read_gmsh_contents(FileTokens& in) {
  GmshContents contents;
  in.expect("$MeshFormat");
  const std::string version = in.word("format version");
  if (version != "2.2" && version != "4.1")
    in.fail("format version", "found " + quoted_excerpt(version) + ", allowed 2.2 or 4.1");
  if (in.integer("file type", 0, 1) != 0) in.fail("file type", "found 1, binary, allowed 0, ASCII");
  in.integer("data size", 1, 1024);
  in.expect("$EndMeshFormat");
  const bool version_2 = version == "2.2";

  while (!in.at_end()) {
    const std::string section = in.word("section");
    const std::size_t line = in.line();
    if (section.size() < 2 || section[0] != '$')
      in.fail("section", "found " + quoted_excerpt(section) + ", allowed a section such as $Nodes");
    if (section == "$PhysicalNames") {
      read_physical_names(in, contents);
    } else if (section == "$Entities") {
      read_entities(in, contents);
    } else if (section == "$Nodes") {
      if (contents.nodes_line != 0) in.fail("$Nodes", "found twice, allowed once");
      contents.nodes_line = line;
      version_2 ? read_nodes_2(in, contents) : read_nodes_4(in, contents);
    } else if (section == "$Elements") {
      if (contents.elements_line != 0) in.fail("$Elements", "found twice, allowed once");
      contents.elements_line = line;
      version_2 ? read_elements_2(in, contents) : read_elements_4(in, contents);
    } else {
      in.skip_to("$End" + section.substr(1));
      continue;
    }
    in.expect("$End" + section.substr(1));
  }
  if (contents.nodes_line == 0) in.fail("$Nodes", "found nothing, required: the section $Nodes");
  if (contents.elements_line == 0) in.fail("$Elements", "found nothing, required: the section $Elements");
  sort_nodes(in, contents.nodes);
  return contents;
}

std::size_t gmsh_node(const FileTokens& in, const GmshContents& contents, const GmshElement& element, int k) {
  const std::vector<GmshNode>& sorted = contents.nodes;
  const std::int64_t tag = element.nodes[static_cast<std::size_t>(k)];
  const auto found = std::lower_bound(sorted.begin(), sorted.end(), tag,
                                      [](const GmshNode& node, std::int64_t value) { return node.tag < value; });
  if (found == sorted.end() || found->tag != tag)
    in.fail_at(element.line, "element " + std::to_string(element.tag),
               "found node " + std::to_string(tag) + ", allowed a node of $Nodes (" +
                   std::to_string(sorted.front().tag) + " to " + std::to_string(sorted.back().tag) + ")");
  return static_cast<std::size_t>(found - sorted.begin());
}

}  // namespace finegauge
