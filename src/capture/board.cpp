#include "simgap/capture/board.h"

#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <opencv2/aruco/charuco.hpp>
#include <opencv2/calib3d.hpp>
#include <opencv2/imgproc.hpp>

#include "simgap/core/error.h"
#include "simgap/core/units.h"

namespace simgap {
namespace {

using cv::aruco::PREDEFINED_DICTIONARY_NAME;
const std::map<std::string, PREDEFINED_DICTIONARY_NAME> kDictionaries = {
    {"4X4_50", cv::aruco::DICT_4X4_50}, {"4X4_100", cv::aruco::DICT_4X4_100}, {"4X4_250", cv::aruco::DICT_4X4_250},
    {"5X5_50", cv::aruco::DICT_5X5_50}, {"5X5_100", cv::aruco::DICT_5X5_100}, {"5X5_250", cv::aruco::DICT_5X5_250},
    {"6X6_50", cv::aruco::DICT_6X6_50}, {"6X6_100", cv::aruco::DICT_6X6_100}, {"6X6_250", cv::aruco::DICT_6X6_250}};

const std::map<std::string, Board::Kind> kKinds = {{"chessboard", Board::Kind::kChessboard},
                                                   {"charuco", Board::Kind::kCharuco},
                                                   {"circles", Board::Kind::kCircles},
                                                   {"asymmetric-circles", Board::Kind::kAsymmetricCircles}};

std::vector<std::string> split(const std::string& text, char separator) {
  std::vector<std::string> parts(1);
  for (const char c : text) {
    if (c == separator) {
      parts.emplace_back();
    } else {
      parts.back() += c;
    }
  }
  return parts;
}

bool findChessboard(const cv::Mat& image, const cv::Size& size, std::vector<cv::Point2f>& corners) {
  if (cv::findChessboardCornersSB(image, size, corners, cv::CALIB_CB_NORMALIZE_IMAGE | cv::CALIB_CB_ACCURACY)) {
    return true;
  }
  // The older detector finds some boards at the image's edge that the newer one misses.
  const int flags = cv::CALIB_CB_ADAPTIVE_THRESH | cv::CALIB_CB_NORMALIZE_IMAGE | cv::CALIB_CB_FAST_CHECK;
  if (!cv::findChessboardCorners(image, size, corners, flags)) return false;
  const cv::TermCriteria until(cv::TermCriteria::COUNT | cv::TermCriteria::EPS, 100, 1e-4);
  cv::cornerSubPix(image, corners, cv::Size(5, 5), cv::Size(-1, -1), until);
  return true;
}

cv::Ptr<cv::aruco::CharucoBoard> charucoBoard(const Board& board) {
  return cv::aruco::CharucoBoard::create(board.size.width, board.size.height, static_cast<float>(board.spacing),
                                         static_cast<float>(board.marker),
                                         cv::aruco::getPredefinedDictionary(kDictionaries.at(board.dictionary)));
}

BoardPoints findCharuco(const cv::Mat& image, const Board& board) {
  const auto charuco = charucoBoard(board);
  std::vector<std::vector<cv::Point2f>> markers;
  std::vector<int> marker_ids;
  cv::aruco::detectMarkers(image, charuco->dictionary, markers, marker_ids);
  BoardPoints points;
  if (marker_ids.empty()) return points;
  cv::aruco::interpolateCornersCharuco(markers, marker_ids, image, charuco, points.pixels, points.ids);
  return points;
}

}  // namespace

Board parseBoard(const std::string& text) {
  const auto refuse = [&] {
    throw ConfigError(fmt::format(
        "--board: found '{}', expected chessboard:9x6:0.025, circles:7x5:0.03, asymmetric-circles:4x11:0.02 or "
        "charuco:7x5:0.04:0.03[:4X4_50] (points per row x column, lengths in metres)",
        text));
  };
  const auto parts = split(text, ':');
  Board board;
  if (parts.size() < 3 || !kKinds.contains(parts[0])) refuse();
  board.kind = kKinds.at(parts[0]);
  const auto size = split(parts[1], 'x');
  const bool charuco = board.kind == Board::Kind::kCharuco;
  if (size.size() != 2 || parts.size() > (charuco ? 5U : 3U) || (charuco && parts.size() < 4)) refuse();
  const auto number = [&](const std::string& word) {
    const auto value = parseNumber(word);
    if (!value || !(*value > 0.0)) refuse();
    return *value;
  };
  const double width = number(size[0]);
  const double height = number(size[1]);
  if (width != std::floor(width) || height != std::floor(height) || width < 3 || height < 3 || width * height > 1e4) {
    refuse();
  }
  board.size = {static_cast<int>(width), static_cast<int>(height)};
  board.spacing = number(parts[2]);
  if (charuco) {
    board.marker = number(parts[3]);
    if (parts.size() == 5) board.dictionary = parts[4];
    if (!(board.marker < board.spacing) || !kDictionaries.contains(board.dictionary)) refuse();
  }
  return board;
}

BoardPoints findBoard(const cv::Mat& image, const Board& board) {
  BoardPoints points;
  bool found = false;
  switch (board.kind) {
    case Board::Kind::kCharuco:
      return findCharuco(image, board);
    case Board::Kind::kChessboard:
      found = findChessboard(image, board.size, points.pixels);
      break;
    case Board::Kind::kCircles:
      found = cv::findCirclesGrid(image, board.size, points.pixels, cv::CALIB_CB_SYMMETRIC_GRID);
      break;
    case Board::Kind::kAsymmetricCircles:
      found = cv::findCirclesGrid(image, board.size, points.pixels, cv::CALIB_CB_ASYMMETRIC_GRID);
      break;
  }
  if (!found) return {};
  for (int id = 0; id < static_cast<int>(points.pixels.size()); ++id) points.ids.push_back(id);
  return points;
}

cv::Point3f boardPoint(const Board& board, int id) {
  const int per_row = board.kind == Board::Kind::kCharuco ? board.size.width - 1 : board.size.width;
  const int row = id / per_row;
  const int column = id % per_row;
  const auto spacing = static_cast<float>(board.spacing);
  if (board.kind == Board::Kind::kAsymmetricCircles) {
    return {spacing * static_cast<float>(2 * column + row % 2), spacing * static_cast<float>(row), 0.0F};
  }
  return {spacing * static_cast<float>(column), spacing * static_cast<float>(row), 0.0F};
}

std::optional<BoardView> joinViews(const Board& board, const std::string& name, const BoardPoints& left,
                                   BoardPoints right) {
  if (left.ids.empty() || right.ids.empty()) return std::nullopt;
  if (board.kind != Board::Kind::kCharuco) {
    const cv::Point2f a = left.pixels.back() - left.pixels.front();
    const cv::Point2f b = right.pixels.back() - right.pixels.front();
    if (a.dot(b) < 0.0F) std::reverse(right.pixels.begin(), right.pixels.end());
  }
  BoardView view{name, {}, {}, {}};
  for (std::size_t i = 0; i < left.ids.size(); ++i) {
    const auto other = std::find(right.ids.begin(), right.ids.end(), left.ids[i]);
    if (other == right.ids.end()) continue;
    view.board.push_back(boardPoint(board, left.ids[i]));
    view.left.push_back(left.pixels[i]);
    view.right.push_back(right.pixels[other - right.ids.begin()]);
  }
  if (view.board.size() < kFewestPoints) return std::nullopt;
  return view;
}

std::vector<BoardView> readCorners(const CsvTable& table) {
  constexpr double kMostPixels = 1e6;  // far outside any image; a float holds no more than 1e38
  const std::vector<std::string> pair = table.text("pair");
  const auto column = [&](const char* name) { return table.quantity(name, ""); };
  const std::vector<double> x = table.quantity("board_x", "m"), y = table.quantity("board_y", "m");
  const std::vector<double> lu = column("left_u_px"), lv = column("left_v_px");
  const std::vector<double> ru = column("right_u_px"), rv = column("right_v_px");
  std::vector<BoardView> views;
  for (std::size_t row = 0; row < table.rows(); ++row) {
    for (const std::vector<double>* pixels : {&lu, &lv, &ru, &rv}) {
      if (std::abs((*pixels)[row]) <= kMostPixels) continue;
      table.fail(row, fmt::format("found {:g} px, expected at most {:g}", (*pixels)[row], kMostPixels));
    }
    if (views.empty() || views.back().name != pair[row]) views.push_back({pair[row], {}, {}, {}});
    BoardView& view = views.back();
    view.board.emplace_back(static_cast<float>(x[row]), static_cast<float>(y[row]), 0.0F);
    view.left.emplace_back(static_cast<float>(lu[row]), static_cast<float>(lv[row]));
    view.right.emplace_back(static_cast<float>(ru[row]), static_cast<float>(rv[row]));
  }
  std::erase_if(views, [](const BoardView& view) { return view.board.size() < kFewestPoints; });
  return views;
}

}  // namespace simgap
