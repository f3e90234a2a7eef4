#include "reality/board_scene.h"

#include <cmath>

namespace simgap::reality {
namespace {

constexpr double kBlack = 30.0, kWhite = 210.0, kWall = 90.0;  // [DN]

/// What a ray through the lens meets; the board has a white margin of one square.
double brightness(const BoardPlate& board, const Eigen::Isometry3d& camera, const Eigen::Vector3d& ray) {
  const Eigen::Vector3d from = camera.translation(), along = camera.linear() * ray;
  const double way = -from.z() / along.z();
  if (!(way > 0.0)) return kWall;
  const Eigen::Vector3d hit = (from + way * along) / board.spacing;
  const double x = std::floor(hit.x()), y = std::floor(hit.y());
  const bool inside = x >= -1 && y >= -1 && x < board.columns && y < board.rows;
  if (inside) return std::lround(x + y) % 2 == 0 ? kBlack : kWhite;
  return x >= -2 && y >= -2 && x <= board.columns && y <= board.rows ? kWhite : kWall;
}

}  // namespace

Image drawBoard(const Lens& lens, const BoardPlate& board, const Eigen::Isometry3d& pose) {
  constexpr int kRays = 4;  // per pixel and direction
  const Eigen::Isometry3d camera = pose.inverse();
  Image image{lens.width, lens.height, {}};
  image.pixels.reserve(lens.width * lens.height);
  for (int y = 0; y < lens.height; ++y) {
    for (int x = 0; x < lens.width; ++x) {
      double sum = 0.0;
      for (int k = 0; k < kRays * kRays; ++k) {
        const Eigen::Vector2d within((k % kRays + 0.5) / kRays - 0.5, (k / kRays + 0.5) / kRays - 0.5);
        sum += brightness(board, camera, lens.ray(Eigen::Vector2d(x, y) + within));
      }
      image.pixels.push_back(static_cast<std::uint8_t>(std::lround(sum / (kRays * kRays))));
    }
  }
  return image;
}

}  // namespace simgap::reality
