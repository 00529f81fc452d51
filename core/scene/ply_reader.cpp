#include "core/scene/ply_reader.hpp"

#include <algorithm>
#include <array>
#include <vector>

#include "core/scene/file_tokens.hpp"
#include "core/scene/ply_header.hpp"
#include "core/scene/scene_error.hpp"
#include "core/scene/surface_limits.hpp"

namespace finegauge {
namespace {

/// Text data under the calls of FileBytes.
struct TextData {
  FileTokens in;
  double number(ScalarType, const std::string& field) { return in.number(field.c_str()); }
  std::int64_t integer(ScalarType, const std::string& field, std::int64_t low, std::int64_t high) {
    return in.integer(field.c_str(), low, high);
  }
  void skip(ScalarType, const std::string& field) { in.word(field); }
  std::size_t left() const { return in.left(); }
  [[noreturn]] void fail(const std::string& field, const std::string& what) const { in.fail(field, what); }
  static std::size_t room(ScalarType) { return 2; }  // a digit and a space
  bool at_end() { return in.at_end(); }
};

struct BinaryData {
  FileBytes in;
  double number(ScalarType type, const std::string& field) { return in.number(type, field); }
  std::int64_t integer(ScalarType type, const std::string& field, std::int64_t low, std::int64_t high) {
    return in.integer(type, field, low, high);
  }
  void skip(ScalarType type, const std::string& field) { in.skip(room(type), field); }
  std::size_t left() const { return in.left(); }
  [[noreturn]] void fail(const std::string& field, const std::string& what) const { in.fail(field, what); }
  static std::size_t room(ScalarType type) { return static_cast<std::size_t>(byte_count(type)); }
  bool at_end() {
    while (in.left() > 0)
      if (const auto byte = in.integer(ScalarType::uint8, "end", 0, 255); byte != '\n' && byte != '\r') return false;
    return true;
  }
};

bool is_face_list(const PlyElement& element, const PlyProperty& property) {
  return element.name == "face" && property.list_count &&
         (property.name == "vertex_indices" || property.name == "vertex_index");
}

template <class Data>
class Body {
 public:
  Body(Data data, std::int64_t vertices) : data_(std::move(data)), vertices_(vertices) {}

  TriangleSurface read(const std::vector<PlyElement>& elements) {
    for (const PlyElement& element : elements) {
      check_room(element);
      if (element.name == "vertex") surface_.vertices.setZero(3, static_cast<Eigen::Index>(element.count));
      if (element.properties.empty()) continue;
      for (std::int64_t i = 0; i < element.count; ++i)
        for (const PlyProperty& property : element.properties) read_property(element, property, i);
    }
    if (!data_.at_end()) data_.fail("end of data", "found more than the header announces, allowed nothing");
    return std::move(surface_);
  }

 private:
  void check_room(const PlyElement& element) const {
    std::size_t smallest = 0;
    for (const PlyProperty& property : element.properties)
      smallest += Data::room(property.list_count ? *property.list_count : property.type);
    const std::size_t least = smallest * static_cast<std::size_t>(element.count);
    if (least > data_.left() + 1)  // the last number of a text needs no space
      data_.fail("element " + element.name, "found " + std::to_string(element.count) + " announced, which take " +
                                                std::to_string(least) + " bytes or more, allowed what the " +
                                                std::to_string(data_.left()) + " bytes left can hold");
  }

  void read_property(const PlyElement& element, const PlyProperty& property, std::int64_t i) {
    if (is_face_list(element, property)) return read_face(property);
    if (property.list_count) {
      const std::int64_t length = data_.integer(*property.list_count, property.name, 0, INT32_MAX);
      for (std::int64_t k = 0; k < length; ++k) data_.skip(property.type, property.name);
      return;
    }
    const int axis = property.name == "x" ? 0 : property.name == "y" ? 1 : property.name == "z" ? 2 : -1;
    if (element.name == "vertex" && axis >= 0)
      surface_.vertices(axis, static_cast<Eigen::Index>(i)) = data_.number(property.type, property.name);
    else
      data_.skip(property.type, property.name);
  }

  void read_face(const PlyProperty& property) {
    const std::int64_t length = data_.integer(*property.list_count, "corners of face", 3, most_surface_triangles);
    if (surface_.triangles.size() + static_cast<std::size_t>(length) > most_surface_triangles)
      data_.fail("element face",
                 "found more than " + std::to_string(most_surface_triangles) + " triangles, allowed as many");
    std::array<int, 3> corners{};
    for (std::int64_t k = 0; k < length; ++k) {
      const auto vertex = static_cast<int>(data_.integer(property.type, property.name, 0, vertices_ - 1));
      if (k < 2) {
        corners[static_cast<std::size_t>(k)] = vertex;
        continue;
      }
      if (k > 2) corners[1] = corners[2];
      corners[2] = vertex;
      surface_.triangles.push_back(corners);
    }
  }

  Data data_;
  std::int64_t vertices_;
  TriangleSurface surface_;
};

[[noreturn]] void refuse(const std::string& file, std::size_t line, const std::string& element,
                         const std::string& what) {
  throw SceneError(file + ":" + std::to_string(line) + ": element " + element + ": " + what);
}

/// The element of this name, which must be there once and hold one or more.
const PlyElement& element_of(const std::string& file, const PlyHeader& header, const char* name) {
  const PlyElement* found = nullptr;
  for (const PlyElement& element : header.elements) {
    if (element.name != name) continue;
    if (found != nullptr) refuse(file, element.line, name, "found twice, allowed once");
    if (element.count == 0) refuse(file, element.line, name, "found 0, allowed one or more");
    found = &element;
  }
  if (found == nullptr) refuse(file, header.lines, name, "found none, required: one");
  return *found;
}

void check_properties(const std::string& file, const PlyElement& vertex, const PlyElement& face) {
  for (const char* axis : {"x", "y", "z"}) {
    const auto is_axis = [&](const PlyProperty& property) { return property.name == axis && !property.list_count; };
    const auto count = std::count_if(vertex.properties.begin(), vertex.properties.end(), is_axis);
    if (count != 1)
      refuse(file, vertex.line, "vertex", "found " + std::to_string(count) + " properties " + axis + ", allowed one");
  }
  int lists = 0;
  bool whole = true;
  for (const PlyProperty& property : face.properties)
    if (is_face_list(face, property)) {
      ++lists;
      whole = whole && is_whole(property.type);
    }
  if (lists != 1 || !whole)
    refuse(file, face.line, "face",
           "found " + std::to_string(lists) + (whole ? "" : " with decimals") +
               " lists vertex_indices or vertex_index, allowed one of a whole type");
}

}  // namespace

TriangleSurface read_ply(const std::string& file, std::string_view bytes) {
  const PlyHeader header = read_ply_header(file, bytes);
  const PlyElement& vertex = element_of(file, header, "vertex");
  check_properties(file, vertex, element_of(file, header, "face"));
  if (header.encoding == PlyEncoding::text) {
    const FileTokens text(file, bytes.substr(header.bytes), header.lines + 1);
    return Body<TextData>({text}, vertex.count).read(header.elements);
  }
  const FileBytes data(file, bytes, header.bytes, header.encoding == PlyEncoding::big_endian);
  return Body<BinaryData>({data}, vertex.count).read(header.elements);
}

}  // namespace finegauge
