/// \file
/// Calibration boards and their corners in images.
#pragma once

#include <opencv2/core.hpp>
#include <optional>
#include <string>
#include <vector>

#include "simgap/core/csv.h"

namespace simgap {

/// A flat board with known points.
struct Board {
  enum class Kind { kChessboard, kCharuco, kCircles, kAsymmetricCircles };
  Kind kind = Kind::kChessboard;
  cv::Size size;                      ///< points per row and column (chessboard: inner corners; ChArUco: squares)
  double spacing = 0.0;               ///< [m] of the points; ChArUco: side of a square
  double marker = 0.0;                ///< [m] ChArUco: side of a marker
  std::string dictionary = "4X4_50";  ///< ChArUco
};

/// "chessboard:9x6:0.025", "circles:7x5:0.03", "asymmetric-circles:4x11:0.02", "charuco:7x5:0.04:0.03[:4X4_50]";
/// lengths in metres. \throws ConfigError
Board parseBoard(const std::string& text);

/// Points of a board in one image.
struct BoardPoints {
  std::vector<int> ids;             ///< number of each point on the board
  std::vector<cv::Point2f> pixels;  ///< [px]
};
/// Empty when the board (or, ChArUco, enough of it) is not seen.
BoardPoints findBoard(const cv::Mat& image, const Board& board);
/// Where a point lies on the board [m].
cv::Point3f boardPoint(const Board& board, int id);

/// The points that both cameras saw of one position of the board.
struct BoardView {
  std::string name;
  std::vector<cv::Point3f> board;        ///< [m]
  std::vector<cv::Point2f> left, right;  ///< [px]
};
/// Empty when both have fewer than kFewestPoints in common. Without marks on the board both cameras may count from
/// opposite corners: the right order is turned when the left one runs against it.
std::optional<BoardView> joinViews(const Board& board, const std::string& name, const BoardPoints& left,
                                   BoardPoints right);
inline constexpr std::size_t kFewestPoints = 8;

/// Corners another program has found: columns pair, board_x_m, board_y_m, left_u_px, left_v_px, right_u_px, right_v_px.
std::vector<BoardView> readCorners(const CsvTable& table);

}  // namespace simgap
