/// \file
/// What joints move in the drawn pose, while all others give way: the numbers by which MuJoCo works out `springdamper`
/// and how far its stops give way.
#pragma once

#include <Eigen/Geometry>
#include <vector>

#include "simgap/model/arm/body.h"

namespace simgap {

struct DrawnBody {
  int parent = -1;      ///< -1: the world; else it stands before this one
  MassProperties mass;  ///< in the world
};

/// One way to move, in the world.
struct DrawnDof {
  std::size_t body;
  bool slides;
  Eigen::Vector3d point, axis;
  double armature = 0.0;
};

/// The diagonal of the inverse of the mass matrix, shape (dofs): acceleration per force [1/(kg m^2)], [1/kg]. Not
/// finite or not positive where a dof moves no mass.
Eigen::VectorXd drawnMobility(const std::vector<DrawnBody>& bodies, const std::vector<DrawnDof>& dofs);

}  // namespace simgap
