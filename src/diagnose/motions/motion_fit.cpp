#include "motion_fit.h"

#include <algorithm>
#include <cmath>

#include "simgap/core/interrupt.h"

namespace simgap {
namespace {

constexpr int kSearches = 3;  // along a cause, each four times as fine as the one before
constexpr int kBeside = 3, kPlaces = 2 * kBeside + 1;
constexpr std::size_t kSome = 4;          // motions to look around with
constexpr double kFarFromPrior = 4.0;     // [sd]: of some hundred parameters none is by chance
constexpr double kFirstDifference = 0.1;  // of derivatives, in prior standard deviations

/// The cause's parameters stand behind the ordinary ones, before the capture's delay.
Eigen::VectorXd withRoom(const Eigen::VectorXd& z, Eigen::Index room) {
  Eigen::VectorXd longer = Eigen::VectorXd::Zero(z.size() + room);
  longer.head(z.size() - 1) = z.head(z.size() - 1);
  longer[longer.size() - 1] = z[z.size() - 1];
  return longer;
}

Eigen::VectorXd squeezed(const Eigen::VectorXd& z, Eigen::Index room) {
  Eigen::VectorXd shorter(z.size() - room);
  shorter.head(shorter.size() - 1) = z.head(shorter.size() - 1);
  shorter[shorter.size() - 1] = z[z.size() - 1];
  return shorter;
}

}  // namespace

MotionPoint::MotionPoint(const MotionPosterior& posterior, const MotionLinearisation& here)
    : posterior_(&posterior), here_(&here) {
  for (std::size_t m = 0; m < posterior.motions().size(); ++m) {
    const bool left_out = here.jacobians[m].rows() == 0;
    weights_.push_back(left_out ? Eigen::VectorXf() : posterior.weights(m, here.at.residuals[m]).cast<float>());
  }
  factor_.compute(posterior.normalEquations(here.z, here.at, here.jacobians).curvature);
  of_clock_ = factor_.solve(Eigen::VectorXd::Unit(here.z.size(), here.z.size() - 1));
}

Eigen::VectorXd MotionPoint::solved(const Eigen::VectorXd& gradient, OwnClock clock) const {
  Eigen::VectorXd moved = factor_.solve(gradient);
  const Eigen::Index last = moved.size() - 1;
  if (clock == OwnClock::kStays) moved -= moved[last] / of_clock_[last] * of_clock_;  // a push that holds it
  return moved;
}

Eigen::VectorXd MotionPoint::projected(std::span<const Eigen::VectorXf> x) const {
  Eigen::VectorXd sum = Eigen::VectorXd::Zero(here_->z.size());
  for (std::size_t m = 0; m < x.size(); ++m) {
    sum += (here_->jacobians[m].transpose() * weights_[m].cwiseProduct(x[m])).cast<double>();
  }
  return sum;
}

double MotionPoint::predicted(std::span<const Eigen::VectorXd> residuals, OwnClock clock) const {
  const Eigen::VectorXd& z = here_->z;
  std::vector<Eigen::VectorXf> x;
  for (std::size_t m = 0; m < residuals.size(); ++m) {
    if (residuals[m].size() != weights_[m].size()) return kInfinity;
    x.push_back(residuals[m].cast<float>());
  }
  Eigen::VectorXd gradient = projected(x);
  for (Eigen::Index i = 0; i < z.size(); ++i) gradient[i] += posterior_->hasPrior(i) ? z[i] : 0.0;
  const Eigen::VectorXd step = -solved(gradient, clock);
  Eigen::VectorXd there = z + step;
  for (Eigen::Index i = 0; i < z.size(); ++i)
    there[i] = std::clamp(there[i], posterior_->lower(i), posterior_->upper(i));
  // Summed there, not as what the step takes away: where a motion goes astray, that is a difference of two numbers far
  // larger than itself.
  double objective = 0.0;
  for (Eigen::Index i = 0; i < z.size(); ++i) objective += posterior_->hasPrior(i) ? 0.5 * there[i] * there[i] : 0.0;
  const Eigen::VectorXf way = (there - z).cast<float>();
  for (std::size_t m = 0; m < x.size(); ++m) {
    const Eigen::VectorXf left = x[m] + here_->jacobians[m] * way;
    objective += 0.5 * weights_[m].cast<double>().dot(left.cast<double>().cwiseAbs2());
  }
  return objective;
}

std::vector<std::size_t> someMotions(std::size_t count) {
  const std::size_t few = std::min(count, kSome);
  std::vector<std::size_t> some(few);
  for (std::size_t i = 0; i < few; ++i) some[i] = (2 * i + 1) * count / (2 * few);
  return some;
}

MotionLinearisation onlyOf(const MotionLinearisation& here, std::span<const std::size_t> some) {
  const std::size_t motions = here.jacobians.size();
  MotionLinearisation few{here.z, {}, std::vector<RowMajorF>(motions, RowMajorF(0, here.z.size()))};
  few.at.residuals.resize(motions);
  for (const std::size_t m : some) {
    few.at.residuals[m] = here.at.residuals[m];
    few.jacobians[m] = here.jacobians[m];
  }
  return few;
}

MotionPosterior::Options optionsWith(const MotionProblem& problem, const std::vector<ArmCause>& causes) {
  MotionPosterior::Options options = problem.options;
  const auto isClock = [](const ArmCause& cause) { return cause.effect->frame_delay != nullptr; };
  if (std::ranges::any_of(causes, isClock)) options.capture_delay_sd = 0.0;
  return options;
}

std::unique_ptr<MotionPosterior> posteriorWith(const MotionProblem& problem, const std::vector<ArmCause>& causes,
                                               std::span<const RecordedMotion> motions) {
  return std::make_unique<MotionPosterior>(withCauses(problem.nominal, causes), motions, std::span<const Pose>(),
                                           choicesWith(problem.parameters, causes, sizesOf(problem.nominal)),
                                           PoseNoise{}, optionsWith(problem, causes));
}

MotionCauseFit::MotionCauseFit(const MotionProblem& problem, std::vector<ArmCause> causes)
    : problem_(&problem), causes_(std::move(causes)), posterior_(posteriorWith(problem, causes_, problem.motions)) {}

Eigen::Index MotionCauseFit::ordinary() const {
  Eigen::Index of_causes = 0;
  for (const ArmCause& cause : causes_) of_causes += fittedParameters(*cause.effect);
  return posterior_->size() - 1 - of_causes;
}

double MotionCauseFit::objective() const {
  double sum = losses().sum();
  for (Eigen::Index i = 0; i < here_.z.size(); ++i)
    sum += posterior_->hasPrior(i) ? 0.5 * here_.z[i] * here_.z[i] : 0.0;
  return sum;
}

/// \returns false where the motions cannot be played
bool MotionCauseFit::place(const Eigen::VectorXd& z) {
  MotionEvaluation at = posterior_->evaluate(z);
  rollouts_ += std::ssize(posterior_->motions());
  stopIfInterrupted();
  if (!at.valid) return false;
  here_.z = z;
  here_.at = std::move(at);
  fitRobustScale(*posterior_, here_.z, here_.at);
  return true;
}

/// The best value of one parameter on some of the motions, from nothing upwards, while the others stay: with
/// derivatives alone these would take over what it should explain, and be far away before it has its size.
void MotionCauseFit::searchAlong(Eigen::Index i) {
  const std::vector<std::size_t> some = someMotions(posterior_->motions().size());
  Eigen::VectorXd found = here_.z;
  double spacing = 0.5 * found[i], from = 0.0, least = kInfinity;
  for (int search = 0; search < kSearches; ++search) {
    std::vector<Eigen::VectorXd> places(kPlaces, found);
    for (int k = 0; k < kPlaces; ++k) {
      places[k][i] = std::clamp(from + k * spacing, posterior_->lower(i), posterior_->upper(i));
    }
    const std::vector<double> objectives = posterior_->objectives(places, some);
    rollouts_ += kPlaces * std::ssize(some);
    stopIfInterrupted();
    const auto best = std::ranges::min_element(objectives) - objectives.begin();
    if (objectives[best] < least) {
      found = places[best];
      least = objectives[best];
    }
    if (best + 1 < kPlaces) spacing *= 0.25;  // else it may be larger still
    from = found[i] - kBeside * spacing;
  }
  if (least < kInfinity && moveTo(found)) fitRobustScale(*posterior_, here_.z, here_.at);
}

void MotionCauseFit::begin(const News& news) {
  const MotionSearchState state = beginSearch(*posterior_);
  here_ = linearise(*posterior_, state.z, state.steps, [&](const MotionSearchNews& now) {
    if (news) news(rollouts_ + static_cast<long>(now.rollouts));
  });
  rollouts_ += (posterior_->size() + 1) * std::ssize(posterior_->motions());
  fitRobustScale(*posterior_, here_.z, here_.at);
}

/// The last cause's parameters as its start has them.
void MotionCauseFit::putAtStart(Eigen::VectorXd& z) const {
  const ArmCause& cause = causes_.back();
  Eigen::Index i = z.size() - 1 - fittedParameters(*cause.effect);
  for (std::size_t k = 0; k < cause.effect->parameters.size(); ++k) {
    if (!cause.effect->parameters[k].fitted) continue;
    z[i] = std::clamp(posterior_->parameters().scaled(i, cause.start[k]), posterior_->lower(i), posterior_->upper(i));
    ++i;
  }
}

bool MotionCauseFit::beginBeside(const MotionPoint& point) {
  const ArmCause& cause = causes_.back();
  const Eigen::Index room = fittedParameters(*cause.effect), first = posterior_->size() - 1 - room;
  Eigen::VectorXd z = withRoom(point.here().z, room);
  const double clock = posterior_->options().capture_delay_sd, was = point.posterior().options().capture_delay_sd;
  if (clock == 0.0) z[z.size() - 1] = 0.0;
  putAtStart(z);
  if (!place(z)) return false;
  searchAlong(first);
  z = here_.z;
  std::vector<MotionEvaluation> moved;
  rollouts_ += room * std::ssize(posterior_->motions());
  for (Eigen::Index k = first; k < first + room; ++k) {
    Eigen::VectorXd there = z;
    const double difference = z[k] + kFirstDifference <= posterior_->upper(k) ? kFirstDifference : -kFirstDifference;
    there[k] += difference;
    moved.push_back(posterior_->evaluate(there));
    stopIfInterrupted();
    if (!moved.back().valid) return false;
    for (std::size_t m = 0; m < moved.back().residuals.size(); ++m) {
      Eigen::VectorXd& column = moved.back().residuals[m];
      column = (column - here_.at.residuals[m]) / difference;
    }
  }
  here_.jacobians.clear();
  for (std::size_t m = 0; m < point.here().jacobians.size(); ++m) {
    const RowMajorF& known = point.here().jacobians[m];
    RowMajorF wider(known.rows(), known.cols() + room);
    wider.leftCols(first) = known.leftCols(first);
    for (Eigen::Index k = 0; k < room; ++k) {
      wider.col(first + k) = moved[k].residuals[m].cast<float>();
    }
    wider.rightCols(1) = known.rightCols(1) * static_cast<float>(was > 0.0 ? clock / was : 0.0);
    here_.jacobians.push_back(std::move(wider));
  }
  return true;
}

bool MotionCauseFit::beginAs(const MotionCauseFit& other, const Eigen::VectorXd& z) {
  if (!place(z)) return false;
  here_.jacobians = other.here_.jacobians;
  return true;
}

bool MotionCauseFit::beginWithout(const MotionCauseFit& other, std::size_t cause) {
  Eigen::Index first = other.ordinary();
  for (std::size_t c = 0; c < cause; ++c) first += fittedParameters(*other.causes_[c].effect);
  const Eigen::Index behind = other.here_.z.size() - first - fittedParameters(*other.causes_[cause].effect);
  Eigen::VectorXd z(posterior_->size());
  z << other.here_.z.head(first), other.here_.z.tail(behind);
  if (!place(z)) return false;
  here_.jacobians.clear();
  for (const RowMajorF& jacobian : other.here_.jacobians) {
    RowMajorF& narrower = here_.jacobians.emplace_back(jacobian.rows(), z.size());
    narrower << jacobian.leftCols(first), jacobian.rightCols(behind);
  }
  return true;
}

bool MotionCauseFit::beginAnew(const MotionCauseFit& other, Eigen::VectorXd z) {
  putAtStart(z);
  if (!beginAs(other, z)) return false;
  searchAlong(z.size() - 1 - fittedParameters(*causes_.back().effect));
  return true;
}

double MotionCauseFit::descend() {
  const double before = here_.at.objective;
  damping_ = std::min(damping_, 1.0);
  simgap::descend(*posterior_, here_, damping_, rollouts_);
  return before - here_.at.objective;
}

double MotionCauseFit::refresh(const News& news) {
  fitRobustScale(*posterior_, here_.z, here_.at);
  rollouts_ += renew(*posterior_, here_, [&](const MotionSearchNews& now) {
    if (news) news(rollouts_ + static_cast<long>(now.rollouts));
  });
  return descend();
}

bool MotionCauseFit::moveTo(const Eigen::VectorXd& z) {
  MotionEvaluation there = posterior_->evaluate(z);
  rollouts_ += std::ssize(posterior_->motions());
  stopIfInterrupted();
  if (!there.valid || !(there.objective < here_.at.objective)) return false;
  here_.z = z;
  here_.at = std::move(there);
  return true;
}

std::optional<Eigen::VectorXd> MotionCauseFit::withoutFar() const {
  Eigen::VectorXd z = here_.z;
  for (Eigen::Index i = 0; i < ordinary(); ++i) {
    if (posterior_->hasPrior(i) && std::abs(z[i]) > kFarFromPrior) z[i] = 0.0;
  }
  if (z == here_.z) return std::nullopt;
  return z;
}

Eigen::VectorXd MotionCauseFit::withoutLast() const {
  return squeezed(here_.z, fittedParameters(*causes_.back().effect));
}

MotionLinearisation MotionCauseFit::withoutLastCause() const {
  const Eigen::Index room = fittedParameters(*causes_.back().effect);
  MotionLinearisation there{withoutLast(), here_.at, {}};
  for (const RowMajorF& jacobian : here_.jacobians) {
    RowMajorF narrower(jacobian.rows(), jacobian.cols() - room);
    narrower << jacobian.leftCols(narrower.cols() - 1), jacobian.rightCols(1);
    there.jacobians.push_back(std::move(narrower));
  }
  return there;
}

double MotionCauseFit::misfit() const { return meanSquareOf(*posterior_, here_.at); }

Eigen::VectorXd MotionCauseFit::losses() const {
  Eigen::VectorXd losses(std::ssize(here_.at.residuals));
  for (std::size_t m = 0; m < here_.at.residuals.size(); ++m) {
    double loss = 0.0;
    for (const ResidualBlock& block : posterior_->motions()[m].blocks()) {
      loss += robustLoss(here_.at.residuals[m].segment(block.first, block.size).squaredNorm());
    }
    losses[m] = 0.5 * posterior_->motions()[m].motion().weight * loss;
  }
  return losses;
}

Eigen::MatrixXd MotionCauseFit::covariance() const {
  return std::max(1.0, misfit()) * covarianceAt(*posterior_, here_);
}

std::vector<Extension> MotionCauseFit::extensions() const {
  const Eigen::VectorXd sd = deviationsOf(*posterior_, here_.at, here_.jacobians, covarianceAt(*posterior_, here_),
                                          stepLeftAt(*posterior_, here_));
  const std::vector<Extension> all = model().extensions;
  std::vector<Extension> found(all.end() - std::ssize(causes_), all.end());
  Eigen::Index i = ordinary();
  for (std::size_t c = 0; c < causes_.size(); ++c) {
    for (std::size_t k = 0; k < causes_[c].effect->parameters.size(); ++k) {
      if (!causes_[c].effect->parameters[k].fitted) continue;
      found[c].parameters[k].sd = posterior_->parameters().slope(i, here_.z[i]) * sd[i];
      ++i;
    }
  }
  return found;
}

}  // namespace simgap
