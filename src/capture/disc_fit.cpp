#include "disc_fit.h"

#include <Eigen/Dense>
#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "simgap/core/statistics.h"

namespace simgap {
namespace {

constexpr int kShared = 3;   // background, blur, fade
constexpr int kPerDisc = 4;  // amplitude, x, y, radius
constexpr int kMostParameters = kShared + kPerDisc * static_cast<int>(kMostDiscs);
constexpr int kDiscRounds = 20;
constexpr double kRimReach = 4.0;    // blurs from the rim: there a disc covers a pixel wholly or not at all
constexpr double kStillStep = 1e-3;  // [px] a centre moves in the last round: far below its standard deviation
constexpr double kStillCost = 1e-4;  // (1) by which the last round lowers the cost
constexpr double kLeastBlur = 0.3;   // [px] a pixel's own width

using Parameters = Eigen::Matrix<double, Eigen::Dynamic, 1, 0, kMostParameters, 1>;
using Information = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, 0, kMostParameters, kMostParameters>;

/// One disc at one pixel: how much of the pixel it covers, its brightness, and their derivatives by rho and radius.
struct Shade {
  double cover = 0.0, light = 0.0;
  double cover_slope = 0.0, light_slope = 0.0;    // by rho
  double cover_growth = 0.0, light_growth = 0.0;  // by radius
  double cover_blur = 0.0, light_blur = 0.0, light_fade = 0.0;
  double along_x = 0.0, along_y = 0.0;  // d rho / d centre
};

Shade shadeAt(double dx, double dy, double radius, double blur, double fade) {
  Shade s;
  const double rho = std::sqrt(dx * dx + dy * dy);
  const double z = (radius - rho) / blur;
  if (z < -kRimReach) return s;
  const bool inner = z > kRimReach;
  s.cover = inner ? 1.0 : normalTail(-z);
  const double bell = inner ? 0.0 : std::exp(-0.5 * z * z) / (blur * std::sqrt(2.0 * std::numbers::pi));
  const double part = rho * rho / (radius * radius);
  const double face = 1.0 - fade * part;
  s.light = s.cover * face;
  s.cover_slope = -bell;
  s.light_slope = -bell * face - s.cover * 2.0 * fade * rho / (radius * radius);
  s.cover_growth = bell;
  s.light_growth = bell * face + s.cover * 2.0 * fade * part / radius;
  s.cover_blur = -bell * z;
  s.light_blur = s.cover_blur * face;
  s.light_fade = -s.cover * part;
  if (rho > 1e-9) {
    s.along_x = -dx / rho;
    s.along_y = -dy / rho;
  }
  return s;
}

/// The pixels and priors of one fit.
class DiscProblem {
 public:
  DiscProblem(const cv::Mat& image, const DiscShape& shape, const std::vector<Disc>& start)
      : image_(image), shape_(shape), discs_(start.size()) {
    const auto within = [](double value, int size) { return std::clamp(static_cast<int>(value), 0, size); };
    double left = 1e9, right = 0.0, top = 1e9, bottom = 0.0;
    for (const Disc& disc : start) {
      const double reach = disc.radius + kDiscRim;
      left = std::min(left, disc.centre.x() - reach);
      right = std::max(right, disc.centre.x() + reach);
      top = std::min(top, disc.centre.y() - reach);
      bottom = std::max(bottom, disc.centre.y() + reach);
    }
    for (int y = within(top, image.rows); y < within(bottom + 2.0, image.rows); ++y) {
      for (int x = within(left, image.cols); x < within(right + 2.0, image.cols); ++x) {
        const bool near = std::any_of(start.begin(), start.end(), [&](const Disc& disc) {
          return (disc.centre - Eigen::Vector2d(x, y)).norm() < disc.radius + kDiscRim;
        });
        if (near) pixels_.emplace_back(x, y);
      }
    }
  }

  /// Normal equations at `p` (pass nullptr for the cost alone). \returns half the sum of squares, in units of the
  /// noise.
  double evaluate(const Parameters& p, Information* matrix, Parameters* gradient) const {
    double cost = 0.0;
    Parameters row = Parameters::Zero(p.size());
    if (matrix != nullptr) {
      matrix->setZero(p.size(), p.size());
      gradient->setZero(p.size());
    }
    for (const cv::Point& pixel : pixels_) {
      const double residual = (model(p, pixel, matrix != nullptr ? &row : nullptr) - valueAt(pixel)) / shape_.noise;
      cost += 0.5 * residual * residual;
      if (matrix == nullptr) continue;
      row /= shape_.noise;
      for (Eigen::Index i = 0; i < row.size(); ++i) {
        if (row[i] != 0.0) matrix->col(i).tail(row.size() - i) += row[i] * row.tail(row.size() - i);
      }
      *gradient += residual * row;
    }
    const auto expect = [&](Eigen::Index i, double mean, double sd) {
      const double off = (p[i] - mean) / sd;
      cost += 0.5 * off * off;
      if (matrix == nullptr) return;
      (*matrix)(i, i) += 1.0 / (sd * sd);
      (*gradient)[i] += off / sd;
    };
    expect(1, shape_.blur, shape_.blur_sd);
    expect(2, shape_.fade, shape_.fade_sd);
    for (std::size_t k = 0; k < discs_; ++k) {
      const auto first = static_cast<Eigen::Index>(kShared + kPerDisc * k);
      expect(first, shape_.amplitude, shape_.amplitude_sd);
      expect(first + 3, shape_.radius, shape_.radius_sd);
    }
    return cost;
  }

  double meanSquare(const Parameters& p) const {
    double squares = 0.0;
    for (const cv::Point& pixel : pixels_) squares += std::pow((valueAt(pixel) - model(p, pixel, nullptr)), 2);
    const auto freedoms = static_cast<double>(pixels_.size()) - static_cast<double>(p.size());
    return squares / (std::max(1.0, freedoms) * shape_.noise * shape_.noise);
  }

  /// Where the mean of 3x3 pixels is furthest above the model.
  void findExcess(const Parameters& p, DiscFit& fit) const {
    for (const cv::Point& at : pixels_) {
      double excess = 0.0;
      for (int n = 0; n < 9; ++n) {
        const cv::Point pixel(std::clamp(at.x + n % 3 - 1, 0, image_.cols - 1),
                              std::clamp(at.y + n / 3 - 1, 0, image_.rows - 1));
        excess += (valueAt(pixel) - model(p, pixel, nullptr)) / 9.0;
      }
      if (excess <= fit.excess_height) continue;
      fit.excess_height = excess;
      fit.excess = {at.x, at.y};
    }
  }

  std::size_t pixels() const { return pixels_.size(); }

 private:
  double valueAt(const cv::Point& pixel) const { return image_.at<unsigned char>(pixel); }

  /// Background and discs, of which each hides those behind it. \param row  derivatives by all parameters, or nullptr
  double model(const Parameters& p, const cv::Point& pixel, Parameters* row) const {
    std::array<Shade, kMostDiscs> shades;
    std::array<double, kMostDiscs> open;  // what the discs in front leave open
    double value = p[0];
    double through = 1.0;
    for (std::size_t k = 0; k < discs_; ++k) {
      const auto first = static_cast<Eigen::Index>(kShared + kPerDisc * k);
      shades[k] = shadeAt(pixel.x - p[first + 1], pixel.y - p[first + 2], p[first + 3], p[1], p[2]);
      open[k] = through;
      value += p[first] * shades[k].light * through;
      through *= 1.0 - shades[k].cover;
    }
    if (row == nullptr) return value;
    row->setZero();
    (*row)[0] = 1.0;
    double behind = 0.0;  // brightness of all that disc k hides, per what it leaves open
    for (std::size_t k = discs_; k-- > 0;) {
      const auto first = static_cast<Eigen::Index>(kShared + kPerDisc * k);
      const Shade& s = shades[k];
      const double lit = p[first] * open[k];
      const double hidden = open[k] * behind;
      const double by_rho = lit * s.light_slope - hidden * s.cover_slope;
      (*row)[1] += lit * s.light_blur - hidden * s.cover_blur;
      (*row)[2] += lit * s.light_fade;
      (*row)[first] = s.light * open[k];
      (*row)[first + 1] = by_rho * s.along_x;
      (*row)[first + 2] = by_rho * s.along_y;
      (*row)[first + 3] = lit * s.light_growth - hidden * s.cover_growth;
      behind = p[first] * s.light + (1.0 - s.cover) * behind;
    }
    return value;
  }

  const cv::Mat& image_;
  const DiscShape& shape_;
  std::size_t discs_;
  std::vector<cv::Point> pixels_;
};

Parameters parametersOf(const DiscShape& shape, const std::vector<Disc>& discs, double background) {
  Parameters p(kShared + kPerDisc * static_cast<Eigen::Index>(discs.size()));
  p.head<3>() << background, shape.blur, shape.fade;
  for (std::size_t k = 0; k < discs.size(); ++k) {
    const Disc& d = discs[k];
    p.segment<4>(static_cast<Eigen::Index>(kShared + kPerDisc * k)) << d.amplitude, d.centre.x(), d.centre.y(),
        d.radius;
  }
  return p;
}

void keepPossible(Parameters& p, double least_radius) {
  p[1] = std::max(p[1], kLeastBlur);
  p[2] = std::clamp(p[2], -0.5, 0.95);
  for (Eigen::Index first = kShared; first < p.size(); first += kPerDisc) {
    p[first + 3] = std::max(p[first + 3], least_radius);
  }
}

/// Levenberg-Marquardt; leaves the normal matrix at the last point in `matrix`.
bool descend(const DiscProblem& problem, Parameters& p, Information& matrix, double least_radius) {
  Parameters gradient;
  double damping = 1e-3;
  double cost = problem.evaluate(p, &matrix, &gradient);
  for (int round = 0; round < kDiscRounds; ++round) {
    Information damped = matrix.selfadjointView<Eigen::Lower>();
    damped.diagonal() *= 1.0 + damping;
    Parameters next = p - damped.ldlt().solve(gradient);
    keepPossible(next, least_radius);
    const double moved = (next - p).tail(p.size() - kShared).cwiseAbs().maxCoeff();
    const double next_cost = problem.evaluate(next, nullptr, nullptr);
    if (next_cost < cost) {
      const bool still = cost - next_cost < kStillCost * cost;
      p = next;
      damping = std::max(1e-6, 0.2 * damping);
      cost = problem.evaluate(p, &matrix, &gradient);
      if (still) return true;
    } else {
      damping *= 10.0;
    }
    if (moved < kStillStep) return true;
    if (damping > 1e6) return false;
  }
  return false;
}

}  // namespace

DiscFit fitDiscs(const cv::Mat& image, const DiscShape& shape, const std::vector<Disc>& start, double background) {
  const DiscProblem problem(image, shape, start);
  DiscFit fit;
  Parameters p = parametersOf(shape, start, background);
  Information matrix;
  if (problem.pixels() <= static_cast<std::size_t>(p.size())) return fit;
  fit.converged = descend(problem, p, matrix, 0.3 * shape.radius);
  fit.background = p[0];
  fit.blur = p[1];
  fit.fade = p[2];
  fit.misfit = problem.meanSquare(p);
  const Information full = matrix.selfadjointView<Eigen::Lower>();
  const Information covariance = full.ldlt().solve(Information::Identity(full.rows(), full.cols()));
  for (std::size_t k = 0; k < start.size(); ++k) {
    const auto first = static_cast<Eigen::Index>(kShared + kPerDisc * k);
    fit.discs.push_back({p.segment<2>(first + 1), p[first + 3], p[first]});
    const Eigen::Matrix2d block = covariance.block<2, 2>(first + 1, first + 1);
    const double mean = 0.5 * block.trace();
    const double spread = std::hypot(0.5 * (block(0, 0) - block(1, 1)), block(0, 1));
    fit.centre_sd.push_back(std::sqrt(std::max(0.0, mean + spread) * std::max(1.0, fit.misfit)));
  }
  problem.findExcess(p, fit);
  return fit;
}

}  // namespace simgap
