#include "simgap/capture/target_check.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "simgap/capture/rigid_fit.h"
#include "simgap/core/decompositions.h"

namespace simgap {
namespace {

using Points = std::vector<Eigen::Vector3d>;

class LikenessSearch {
 public:
  LikenessSearch(const Points& a, const Points& b, std::size_t count, bool self)
      : a_(a), b_(b), count_(count), self_(self), taken_(b.size(), 0) {
    best_.rms = std::numeric_limits<double>::infinity();
  }
  Likeness run() {
    choose(0);
    return best_;
  }

 private:
  void choose(std::size_t next) {
    if (markers_.size() == count_) return judge();
    if (a_.size() - next < count_ - markers_.size()) return;
    for (std::size_t j = 0; j < b_.size(); ++j) {
      if (taken_[j] || !worthwhile(next, j)) continue;
      taken_[j] = 1;
      markers_.push_back(static_cast<int>(next));
      taken_for_.push_back(static_cast<int>(j));
      choose(next + 1);
      markers_.pop_back();
      taken_for_.pop_back();
      taken_[j] = 0;
    }
    choose(next + 1);
  }

  bool worthwhile(std::size_t i, std::size_t j) const {
    const double limit = best_.rms * std::sqrt(2.0 * static_cast<double>(count_));
    for (std::size_t k = 0; k < markers_.size(); ++k) {
      const double in_a = (a_[i] - a_[markers_[k]]).norm();
      const double in_b = (b_[j] - b_[taken_for_[k]]).norm();
      if (std::abs(in_a - in_b) >= limit) return false;
    }
    return true;
  }

  void judge() {
    if (self_ && markers_ == taken_for_) return;
    Points from, to;
    for (std::size_t k = 0; k < count_; ++k) {
      from.push_back(a_[markers_[k]]);
      to.push_back(b_[taken_for_[k]]);
    }
    const double rms = fitRms(umeyama(from, to), from, to);
    if (rms >= best_.rms) return;
    best_.rms = rms;
    best_.markers = markers_;
    best_.taken_for = taken_for_;
  }

  const Points& a_;
  const Points& b_;
  std::size_t count_;
  bool self_;
  std::vector<char> taken_;
  std::vector<int> markers_, taken_for_;
  Likeness best_;
};

double smallestGap(const Points& markers) {
  std::vector<double> distances;
  for (std::size_t i = 0; i < markers.size(); ++i) {
    for (std::size_t j = 0; j < i; ++j) distances.push_back((markers[i] - markers[j]).norm());
  }
  std::sort(distances.begin(), distances.end());
  double gap = std::numeric_limits<double>::infinity();
  for (std::size_t k = 1; k < distances.size(); ++k) gap = std::min(gap, distances[k] - distances[k - 1]);
  return gap;
}

double flatnessOf(const Points& markers) {
  Eigen::Vector3d mean = Eigen::Vector3d::Zero();
  for (const auto& m : markers) mean += m / static_cast<double>(markers.size());
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();
  for (const auto& m : markers) {
    covariance += (m - mean) * (m - mean).transpose() / static_cast<double>(markers.size());
  }
  return std::sqrt(std::max(0.0, symmetricEigen(covariance).values[0]));
}

}  // namespace

Likeness closestLikeness(const Points& a, const Points& b, std::size_t count, bool self, bool mirrored) {
  Points image = b;
  if (mirrored) {
    for (auto& p : image) p.x() = -p.x();
  }
  Likeness likeness = LikenessSearch(a, image, count, self).run();
  likeness.mirrored = mirrored;
  return likeness;
}

bool TargetSetReport::sound() const {
  const auto bad = [this](const Likeness& likeness) { return confused(likeness); };
  const auto bad_target = [&](const TargetReport& t) { return bad(t.symmetry) || bad(t.mirror); };
  return std::none_of(targets.begin(), targets.end(), bad_target) && std::none_of(cross.begin(), cross.end(), bad);
}

TargetSetReport checkTargets(const TargetSet& set, double noise) {
  TargetSetReport report;
  report.noise = noise;
  const auto label = [](Likeness likeness, std::size_t from, std::size_t to) {
    likeness.from = static_cast<int>(from);
    likeness.to = static_cast<int>(to);
    return likeness;
  };
  for (std::size_t t = 0; t < set.targets.size(); ++t) {
    const Points& m = set.targets[t].markers;
    report.targets.push_back({set.targets[t].name, smallestGap(m), flatnessOf(m),
                              label(closestLikeness(m, m, m.size(), true, false), t, t),
                              label(closestLikeness(m, m, m.size(), false, true), t, t),
                              label(closestLikeness(m, m, 3, true, false), t, t)});
    for (std::size_t o = 0; o < t; ++o) {
      const Points& other = set.targets[o].markers;
      const std::size_t count = std::min(m.size(), other.size());
      report.cross.push_back(label(closestLikeness(m, other, count, false, false), t, o));
      report.cross_triple.push_back(label(closestLikeness(m, other, 3, false, false), t, o));
    }
  }
  return report;
}

}  // namespace simgap
