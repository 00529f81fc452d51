#include "core/scene/section_reader.hpp"

#include <cassert>
#include <cmath>
#include <limits>
#include <stdexcept>
#include <utility>

#include "core/scene/number_limits.hpp"
#include "core/scene/scene_error.hpp"
#include "core/scene/text_file.hpp"

namespace finegauge {
namespace {

/// A node and where it stands in its key's value; the words of the place are made only when something is wrong.
struct Place {
  const SceneDocument& document;
  const SceneKey& row;
  const std::string& section_field;
  const toml::node& node;
  std::array<int, 2> entry = {-1, -1};

  Place at(int i, const toml::node& child) const {
    Place inner{document, row, section_field, child, entry};
    inner.entry[entry[0] < 0 ? 0 : 1] = i;
    return inner;
  }
  [[noreturn]] void refuse(const std::string& also = {}) const {
    std::string field = section_field.empty() ? "" : section_field + ".";
    field += row.key;
    for (const int i : entry)
      if (i >= 0) field += "[" + std::to_string(i) + "]";
    document.fail(field, node.source().begin.line,
                  "found " + excerpt(node) + ", allowed " + allowed_values(row) + also);
  }
};

double to_number(const Place& place) {
  double value = 0.0;
  if (const auto* whole = place.node.as_integer())
    value = static_cast<double>(whole->get());
  else if (const auto* real = place.node.as_floating_point())
    value = real->get();
  else
    place.refuse();
  if (!place.row.range.contains(value)) place.refuse();
  if (!has_sound_magnitude(value)) place.refuse(", of a magnitude of 1e-60 to 1e60 unless zero");
  return value;
}

int to_integer(const Place& place) {
  const auto* whole = place.node.as_integer();
  if (!whole || !place.row.range.contains(static_cast<double>(whole->get())) || !std::in_range<int>(whole->get()))
    place.refuse();
  return static_cast<int>(whole->get());
}

/// A list of `size` entries, or of one or more when size is 0.
template <class Convert>
auto to_list(const Place& place, std::size_t size, Convert convert) {
  const toml::array* list = place.node.as_array();
  if (!list || list->empty() || (size != 0 && list->size() != size)) place.refuse();
  std::vector<decltype(convert(place))> values;
  values.reserve(list->size());
  int i = 0;
  for (const toml::node& child : *list) values.push_back(convert(place.at(i++, child)));
  return values;
}

Eigen::Vector3d to_vector(const Place& place) {
  const std::vector<double> values = to_list(place, 3, to_number);
  return {values[0], values[1], values[2]};
}

Eigen::Vector3d to_direction(const Place& place) {
  const Eigen::Vector3d direction = to_vector(place);
  if (direction.isZero(0.0)) place.refuse();
  return direction;
}

Eigen::Matrix3d to_matrix(const Place& place) {
  const std::vector<Eigen::Vector3d> rows = to_list(place, 3, to_vector);
  Eigen::Matrix3d matrix;
  for (int i = 0; i < 3; ++i) matrix.row(i) = rows[static_cast<std::size_t>(i)].transpose();
  return matrix;
}

std::string to_text(const Place& place) {
  const auto* text = place.node.as_string();
  if (!text) place.refuse();
  if (text->get().empty() && place.row.default_value != "\"\"") place.refuse();
  if (text->get().find('\0') != std::string::npos) place.refuse();
  return text->get();
}

std::string to_choice(const Place& place) {
  const std::string text = to_text(place);
  std::string_view rest = place.row.choices;
  while (true) {
    const std::size_t bar = rest.find('|');
    if (rest.substr(0, bar) == text) return text;
    if (bar == std::string_view::npos) place.refuse();
    rest = rest.substr(bar + 1);
  }
}

std::vector<int> to_axes(const Place& place) {
  const auto axis = [](const Place& entry) {
    const auto* text = entry.node.as_string();
    if (!text || text->get().size() != 1 || text->get()[0] < 'x' || text->get()[0] > 'z') entry.refuse();
    return text->get()[0] - 'x';
  };
  const std::vector<int> axes = to_list(place, 0, axis);
  for (std::size_t i = 0; i < axes.size(); ++i)
    for (std::size_t j = 0; j < i; ++j)
      if (axes[i] == axes[j]) place.refuse();
  return axes;
}

RefinementTemplate to_refinement(const Place& place) {
  try {
    return parse_refinement_template(to_text(place));
  } catch (const std::invalid_argument&) {
    place.refuse();
  }
}

std::array<int, 3> to_integers3(const Place& place) {
  const std::vector<int> values = to_list(place, 3, to_integer);
  return {values[0], values[1], values[2]};
}

std::vector<int> to_index_list(const Place& place) { return to_list(place, 0, to_integer); }

std::vector<std::array<double, 2>> to_course(const Place& place) {
  double last_time = -std::numeric_limits<double>::infinity();
  return to_list(place, 0, [&](const Place& entry) {
    const std::vector<double> pair = to_list(entry, 2, to_number);
    if (!(pair[0] > last_time)) entry.refuse();
    last_time = pair[0];
    return std::array{pair[0], pair[1]};
  });
}

bool to_boolean(const Place& place) {
  const auto* boolean = place.node.as_boolean();
  if (!boolean) place.refuse();
  return boolean->get();
}

}  // namespace

SectionReader::SectionReader(const SceneDocument& document, std::string_view section, std::string field,
                             const toml::table* table)
    : document_(&document),
      section_(find_section(section)->name),
      field_(std::move(field)),
      table_(table),
      moving_(document.root().contains("dynamics")) {
  if (table_)
    for (const auto& [key, node] : *table_) {
      if (section_.empty() && find_section(key.str()) && !key.empty()) continue;
      if (const SceneKey* row = find_key(section_, key.str())) {
        if (!row->applies(moving_))
          refuse(key.str(), std::string("found in a ") + (moving_ ? "moving" : "static") + " scene, allowed " +
                                (moving_ ? "without" : "with") + " [dynamics] only: " + std::string(row->why_not));
        check_type(*row);
        continue;
      }
      const std::string name = (field_.empty() ? "" : field_ + ".") + quoted_excerpt(std::string(key.str()));
      document_->fail(name, key.source().begin.line, "unknown key" + suggest_key(section_, key.str()));
    }
  for (const SceneKey& row : scene_keys())
    if (row.section == section_ && row.default_value == required_key && row.applies(moving_) && !has(row.key))
      refuse_missing(row.key, "required");
}

const toml::node* SectionReader::given(std::string_view key) const {
  assert(find_key(section_, key));
  return table_ ? table_->get(key) : nullptr;
}

void SectionReader::check_type(const SceneKey& row) const {
  const Place place{*document_, row, field_, *given(row.key)};
  switch (row.type) {
    case KeyType::text:
      to_text(place);
      break;
    case KeyType::choice:
      to_choice(place);
      break;
    case KeyType::boolean:
      to_boolean(place);
      break;
    case KeyType::integer:
      to_integer(place);
      break;
    case KeyType::number:
      to_number(place);
      break;
    case KeyType::integers3:
      to_integers3(place);
      break;
    case KeyType::vector:
      to_vector(place);
      break;
    case KeyType::direction:
      to_direction(place);
      break;
    case KeyType::matrix:
      to_matrix(place);
      break;
    case KeyType::axes:
      to_axes(place);
      break;
    case KeyType::refinement:
      to_refinement(place);
      break;
    case KeyType::points:
      to_list(place, 0, to_vector);
      break;
    case KeyType::index_list:
      to_index_list(place);
      break;
    case KeyType::index_lists:
      to_list(place, 0, to_index_list);
      break;
    case KeyType::course:
      to_course(place);
      break;
  }
}

template <class Convert>
auto SectionReader::value(std::string_view key, Convert convert) const {
  const SceneKey* row = find_key(section_, key);
  assert(row && row->applies(moving_));
  if (const toml::node* node = given(key)) return convert(Place{*document_, *row, field_, *node});
  const toml::table parsed = toml::parse("value = " + std::string(row->default_in(moving_)));
  return convert(Place{*document_, *row, field_, *parsed.get("value")});
}

std::string SectionReader::text(std::string_view key) const { return value(key, to_text); }
bool SectionReader::boolean(std::string_view key) const { return value(key, to_boolean); }
int SectionReader::integer(std::string_view key) const { return value(key, to_integer); }
double SectionReader::number(std::string_view key) const { return value(key, to_number); }
std::array<int, 3> SectionReader::integers3(std::string_view key) const { return value(key, to_integers3); }
Eigen::Vector3d SectionReader::vector(std::string_view key) const { return value(key, to_vector); }
Eigen::Matrix3d SectionReader::matrix(std::string_view key) const { return value(key, to_matrix); }
std::vector<int> SectionReader::axes(std::string_view key) const { return value(key, to_axes); }
RefinementTemplate SectionReader::refinement(std::string_view key) const { return value(key, to_refinement); }
std::vector<int> SectionReader::index_list(std::string_view key) const { return value(key, to_index_list); }

std::vector<std::array<double, 2>> SectionReader::course(std::string_view key) const { return value(key, to_course); }

Eigen::Matrix3Xd SectionReader::points(std::string_view key) const {
  const auto list = value(key, [](const Place& place) { return to_list(place, 0, to_vector); });
  Eigen::Matrix3Xd points(3, static_cast<Eigen::Index>(list.size()));
  for (std::size_t i = 0; i < list.size(); ++i) points.col(static_cast<Eigen::Index>(i)) = list[i];
  return points;
}

std::vector<std::vector<int>> SectionReader::index_lists(std::string_view key) const {
  return value(key, [](const Place& place) { return to_list(place, 0, to_index_list); });
}

void SectionReader::refuse(std::string_view key, const std::string& found_and_allowed, int entry) const {
  std::string field = (field_.empty() ? "" : field_ + ".") + std::string(key);
  const toml::node* node = given(key);
  if (node && entry >= 0) {
    field += "[" + std::to_string(entry) + "]";
    node = node->as_array()->get(static_cast<std::size_t>(entry));
  }
  document_->fail(field,
                  node     ? node->source().begin.line
                  : table_ ? table_->source().begin.line
                           : 0,
                  found_and_allowed);
}

void SectionReader::refuse_missing(std::string_view key, const std::string& why) const {
  const SceneKey* row = find_key(section_, key);
  assert(row);
  refuse(key, "found nothing, " + why + ": " + allowed_values(*row));
}

}  // namespace finegauge
