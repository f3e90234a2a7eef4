/// \file
/// Solids by their surfaces: triangles of STL and OBJ files, and what they weigh.
#pragma once

#include <Eigen/Core>
#include <array>
#include <string>
#include <vector>

namespace simgap {

struct Mesh {
  std::vector<Eigen::Vector3d> points;        ///< each place once
  std::vector<std::array<int, 3>> triangles;  ///< indices of points
};

/// \param text  of an STL file, in ASCII or binary, or of an OBJ file \param name  of it, with its ending
/// \throws DataError with file and line: no mesh, no triangle, numbers that are none, corners that are not there
Mesh readMesh(const std::string& text, const std::string& name);

/// A body of density 1 within a closed surface, about its centre of mass.
struct MeshVolume {
  double volume;           ///< [m^3]
  Eigen::Vector3d centre;  ///< [m]
  Eigen::Matrix3d second;  ///< integral of x x^T about the centre [m^5]
  /// Inertia of that mass spread evenly [kg m^2].
  Eigen::Matrix3d inertia(double mass) const {
    return mass / volume * (second.trace() * Eigen::Matrix3d::Identity() - second);
  }
};

/// Exact, as a sum over the tetrahedra that each triangle makes with one point (a, b, c its corners, s = a + b + c):
/// det(a, b, c)/6, s det/24, det/120 (a a^T + b b^T + c c^T + s s^T).
/// \throws DataError: an edge without exactly two triangles that face the same way, no volume
MeshVolume volumeOf(const Mesh& mesh, const std::string& name);

}  // namespace simgap
