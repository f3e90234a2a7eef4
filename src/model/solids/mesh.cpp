#include "simgap/model/solids/mesh.h"

#include <fmt/format.h>

#include <Eigen/LU>
#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <map>
#include <optional>
#include <string_view>

#include "simgap/core/error.h"
#include "simgap/core/units.h"
#include "simgap/core/words.h"

namespace simgap {
namespace {

constexpr std::size_t kMostTriangles = 5'000'000;
constexpr std::size_t kStlHeader = 80, kStlCount = 4, kStlTriangle = 50;  // [bytes] of a binary STL

[[noreturn]] void failMesh(const std::string& name, std::size_t line, const std::string& sentence) {
  throw DataError(line > 0 ? fmt::format("{}:{}: {}", name, line, sentence) : fmt::format("{}: {}", name, sentence));
}

/// Corners become points, each place once; triangles without an area vanish.
class MeshBuilder {
 public:
  explicit MeshBuilder(const std::string& name) : name_(name) {}

  int point(const Eigen::Vector3d& p, std::size_t line) {
    if (!p.allFinite()) failMesh(name_, line, "found a coordinate that is no finite number");
    const auto [at, added] = index_.try_emplace({p.x(), p.y(), p.z()}, static_cast<int>(mesh_.points.size()));
    if (added) mesh_.points.push_back(p);
    return at->second;
  }
  void triangle(int a, int b, int c, std::size_t line) {
    if (mesh_.triangles.size() >= kMostTriangles) {
      failMesh(name_, line, fmt::format("found more than {} triangles", kMostTriangles));
    }
    if (a != b && b != c && c != a) mesh_.triangles.push_back({a, b, c});
  }
  Mesh finish() {
    if (mesh_.triangles.empty()) failMesh(name_, 0, "found no triangle, expected a closed surface");
    return std::move(mesh_);
  }

 private:
  const std::string& name_;
  Mesh mesh_;
  std::map<std::array<double, 3>, int> index_;
};

bool isBinaryStl(const std::string& text) {
  if (text.size() < kStlHeader + kStlCount) return false;
  std::uint32_t count = 0;
  std::memcpy(&count, text.data() + kStlHeader, sizeof(count));
  return text.size() == kStlHeader + kStlCount + kStlTriangle * std::size_t{count};
}

/// Per triangle twelve little-endian floats, the normal first, and two bytes.
Mesh readBinaryStl(const std::string& text, const std::string& name) {
  MeshBuilder builder(name);
  for (std::size_t at = kStlHeader + kStlCount; at < text.size(); at += kStlTriangle) {
    std::array<float, 12> numbers;
    std::memcpy(numbers.data(), text.data() + at, sizeof(numbers));
    std::array<int, 3> corners;
    for (std::size_t k = 0; k < 3; ++k) {
      corners[k] = builder.point({numbers[3 + 3 * k], numbers[4 + 3 * k], numbers[5 + 3 * k]}, 0);
    }
    builder.triangle(corners[0], corners[1], corners[2], 0);
  }
  return builder.finish();
}

Eigen::Vector3d readPlace(Words& words, const std::string& name, std::size_t line) {
  Eigen::Vector3d p;
  for (double& coordinate : p) {
    const std::optional<double> number = parseNumber(words.next());
    if (!number) failMesh(name, line, "found a corner that is not three numbers");
    coordinate = *number;
  }
  return p;
}

/// Calls action(number, first word, the words behind it), lines counted from 1.
template <class Action>
void forEachLine(std::string_view text, const Action& action) {
  for (std::size_t number = 1; !text.empty(); ++number) {
    Words words(takeLine(text));
    const std::string_view word = words.next();
    action(number, word, words);
  }
}

Mesh readAsciiStl(const std::string& text, const std::string& name) {
  MeshBuilder builder(name);
  std::vector<int> corners;
  forEachLine(text, [&](std::size_t number, std::string_view word, Words& words) {
    if (word == "vertex") corners.push_back(builder.point(readPlace(words, name, number), number));
    if (word != "endloop") return;
    if (corners.size() != 3) failMesh(name, number, fmt::format("found a facet of {} corners", corners.size()));
    builder.triangle(corners[0], corners[1], corners[2], number);
    corners.clear();
  });
  return builder.finish();
}

/// "v x y z" and "f a b c ...", corners counted from 1, or back from the end where negative, perhaps with "/…" behind.
Mesh readObj(const std::string& text, const std::string& name) {
  MeshBuilder builder(name);
  std::vector<int> places;  // of the file
  forEachLine(text, [&](std::size_t number, std::string_view word, Words& words) {
    if (word == "v") places.push_back(builder.point(readPlace(words, name, number), number));
    if (word != "f") return;
    std::vector<int> corners;
    for (std::string_view corner = words.next(); !corner.empty(); corner = words.next()) {
      long index = 0;  // stays so where no number stands
      std::from_chars(corner.data(), corner.data() + corner.size(), index);
      const long at = index < 0 ? std::ssize(places) + index : index - 1;
      if (at < 0 || at >= std::ssize(places)) failMesh(name, number, fmt::format("found no corner '{}'", corner));
      corners.push_back(places[at]);
    }
    if (corners.size() < 3) failMesh(name, number, fmt::format("found a face of {} corners", corners.size()));
    for (std::size_t k = 2; k < corners.size(); ++k) {
      builder.triangle(corners[0], corners[k - 1], corners[k], number);
    }
  });
  return builder.finish();
}

/// Every edge runs once each way.
void refuseOpen(const Mesh& mesh, const std::string& name) {
  std::vector<std::array<int, 2>> edges;
  edges.reserve(3 * mesh.triangles.size());
  for (const std::array<int, 3>& t : mesh.triangles) {
    for (std::size_t k = 0; k < 3; ++k) edges.push_back({t[k], t[(k + 1) % 3]});
  }
  std::ranges::sort(edges);
  const auto twice = std::ranges::adjacent_find(edges);
  const auto place = [&](const std::array<int, 2>& edge) {
    const Eigen::Vector3d& p = mesh.points[edge[0]];
    return fmt::format("({:.4g}, {:.4g}, {:.4g})", p.x(), p.y(), p.z());
  };
  if (twice != edges.end()) {
    failMesh(name, 0,
             fmt::format("found triangles at {} that face different ways, or share an edge with more than "
                         "one other",
                         place(*twice)));
  }
  const auto open = std::ranges::find_if(edges, [&](const std::array<int, 2>& edge) {
    return !std::ranges::binary_search(edges, std::array<int, 2>{edge[1], edge[0]});
  });
  if (open != edges.end()) {
    failMesh(name, 0,
             fmt::format("found an edge of one triangle alone at {}, expected a closed surface", place(*open)));
  }
}

}  // namespace

Mesh readMesh(const std::string& text, const std::string& name) {
  const std::string ending = name.substr(std::min(name.size(), name.rfind('.')));
  if (ending == ".obj" || ending == ".OBJ") return readObj(text, name);
  if (ending == ".stl" || ending == ".STL")
    return isBinaryStl(text) ? readBinaryStl(text, name) : readAsciiStl(text, name);
  throw DataError(fmt::format("{}: found the ending '{}', expected .stl or .obj", name, ending));
}

MeshVolume volumeOf(const Mesh& mesh, const std::string& name) {
  refuseOpen(mesh, name);
  const Eigen::Vector3d& origin = mesh.points.front();  // near: less is lost to rounding
  double volume = 0.0, size = 0.0;
  Eigen::Vector3d first = Eigen::Vector3d::Zero();
  Eigen::Matrix3d second = Eigen::Matrix3d::Zero();
  for (const std::array<int, 3>& t : mesh.triangles) {
    std::array<Eigen::Vector3d, 3> p;
    for (std::size_t k = 0; k < 3; ++k) p[k] = mesh.points[t[k]] - origin;
    const Eigen::Vector3d sum = p[0] + p[1] + p[2];
    const double det = p[0].dot(p[1].cross(p[2]));
    volume += det / 6.0;
    size = std::max(size, sum.norm());
    first += det / 24.0 * sum;
    Eigen::Matrix3d squares = sum * sum.transpose();
    for (const Eigen::Vector3d& corner : p) squares += corner * corner.transpose();
    second += det / 120.0 * squares;
  }
  constexpr double kFlat = 1e-12;  // of the cube about it
  if (std::abs(volume) <= kFlat * size * size * size) failMesh(name, 0, "found a surface that encloses no volume");
  const Eigen::Vector3d centre = first / volume;
  // Of triangles that face inwards everything has the other sign.
  const double sign = std::copysign(1.0, volume);
  return {std::abs(volume), origin + centre, sign * (second - volume * centre * centre.transpose())};
}

}  // namespace simgap
