#include "repose/scene/case.hpp"

#include <array>
#include <cstddef>

#include "repose/base/error.hpp"
#include "repose/base/text.hpp"

namespace repose::scene {
namespace {

constexpr std::array<const char*, 6> kFaces = {"-x", "+x", "-y", "+y", "-z", "+z"};

bool is_face(std::string_view text) {
  for (const char* face : kFaces)
    if (text == face) return true;
  return false;
}

}  // namespace

std::vector<Wall> box_walls(const std::string& name, const std::string& material, const Vec3& lower,
                            const Vec3& upper, const std::vector<std::string>& open) {
  for (const std::string& face : open)
    if (!is_face(face))
      throw InputError("box \"" + name + "\": open = \"" + face +
                       "\" is not a face; name -x, +x, -y, +y, -z or +z");
  std::vector<Wall> walls;
  for (std::size_t f = 0; f < kFaces.size(); ++f) {
    bool is_open = false;
    for (const std::string& face : open) is_open = is_open || face == kFaces[f];
    if (is_open) continue;
    const int axis = static_cast<int>(f / 2);
    const int u = (axis + 1) % 3;
    const int v = (axis + 2) % 3;
    Wall wall;
    wall.name = name + "." + kFaces[f];
    wall.material = material;
    Rectangle face;
    face.origin = lower;
    if (f % 2 == 1) face.origin[axis] = upper[axis];
    face.edge_u[u] = upper[u] - lower[u];
    face.edge_v[v] = upper[v] - lower[v];
    wall.shape = face;
    walls.push_back(wall);
  }
  return walls;
}

bool is_inside(const Region& region, const Vec3& x) {
  if ((x.array() < region.lower.array()).any() || (x.array() >= region.upper.array()).any())
    return false;
  if (!region.cylinder) return true;
  const Vec3 axis = region.cylinder->end - region.cylinder->start;
  const Vec3 from_start = x - region.cylinder->start;
  const double along = from_start.dot(axis) / axis.squaredNorm();
  const double off_axis2 = (from_start - along * axis).squaredNorm();
  return along >= 0.0 && along < 1.0 &&
         off_axis2 < region.cylinder->radius_m * region.cylinder->radius_m;
}

const ClumpShape& clump_shape(const Case& scene, const std::string& name) {
  std::vector<std::string> names;
  for (const std::vector<ClumpShape>* shapes : {&scene.clumps, &shipped_clumps()})
    for (const ClumpShape& shape : *shapes) {
      if (shape.name == name) return shape;
      names.push_back(shape.name);
    }
  throw InputError("clump \"" + name + "\" is not known; the case has " + listed(names));
}

int material_index(const Case& scene, const std::string& name) {
  std::vector<std::string> names;
  for (std::size_t m = 0; m < scene.materials.size(); ++m) {
    if (scene.materials[m].name == name) return static_cast<int>(m);
    names.push_back(scene.materials[m].name);
  }
  throw InputError("material \"" + name + "\" is not known; the case has " +
                   (names.empty() ? std::string("none") : listed(names)));
}

int pair_index(const Case& scene, int first, int second) {
  const std::string& a = scene.materials.at(static_cast<std::size_t>(first)).name;
  const std::string& b = scene.materials.at(static_cast<std::size_t>(second)).name;
  for (std::size_t p = 0; p < scene.pairs.size(); ++p) {
    const PairCoefficients& pair = scene.pairs[p];
    if ((pair.first == a && pair.second == b) || (pair.first == b && pair.second == a))
      return static_cast<int>(p);
  }
  return -1;
}

std::vector<int> walls_named(const Case& scene, const std::string& name) {
  std::vector<int> found;
  for (std::size_t w = 0; w < scene.walls.size(); ++w) {
    const std::string& wall = scene.walls[w].name;
    const bool face_of_box = wall.size() > name.size() + 1 && wall.starts_with(name) &&
                             wall[name.size()] == '.' && is_face(wall.substr(name.size() + 1));
    if (wall == name || face_of_box) found.push_back(static_cast<int>(w));
  }
  return found;
}

}  // namespace repose::scene
