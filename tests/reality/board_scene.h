/// \file
/// A printed chessboard as a camera sees it: each pixel is the mean of rays, bent back through the lens, that meet the
/// board. Shares no code with the calibration.
#pragma once

#include <Eigen/Geometry>

#include "reality/stereo_scene.h"

namespace simgap::reality {

struct BoardPlate {
  int columns = 9, rows = 6;  ///< inner corners
  double spacing = 0.025;     ///< [m]
};

/// \param pose  of the board in the camera's frame: its first inner corner is the origin, its corners span x and y.
Image drawBoard(const Lens& lens, const BoardPlate& board, const Eigen::Isometry3d& pose);

}  // namespace simgap::reality
