/// \file
/// Hypotheses on a log: each refits the whole model with one more effect, on the training blocks, and is judged on
/// folds of them that its refit has not seen.
#pragma once

#include <algorithm>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "diagnose/paired_error.h"
#include "few_rows.h"
#include "simgap/core/bytes.h"
#include "simgap/diagnose/logs/log_diagnosis.h"

namespace simgap {

/// An effect to be tried; `fixed`: its reference parameters, where the data do not choose them.
struct Hypothesis {
  const ActuatorEffect* effect;
  std::string target;         ///< channels of an unnamed dependence
  std::vector<double> fixed;  ///< shape (P), or empty
};

/// A model that was fitted to the training blocks.
struct Fitted {
  std::shared_ptr<const ActuatorRegression> model;
  std::vector<double> theta;  ///< shape (P)
  double mse = 0.0;           ///< on the training rows
  Eigen::VectorXd unseen;     ///< shape (rows): errors of refits to the other folds; 0: no training row; or empty
  GroupErrors validation;     ///< their squares on pieces; empty until validate()
};

/// A model without a cause and with it, both beside something that is no cause.
struct Beside {
  Fitted rest, full;
};

/// How many rows of the blocks count. \param keep  shape (rows)
double rowsIn(const std::vector<Block>& blocks, const std::vector<bool>& keep);
/// Errors, shape (rows); 0 where they do not count.
Eigen::VectorXd residualOf(const Fitted& fitted);
/// The same at another place. \param theta  shape (P)
Eigen::VectorXd residualOf(const Fitted& fitted, std::span<const double> theta);

/// One hypothesis on top of a model.
struct Trial {
  Hypothesis hypothesis;
  Fitted fitted;
  double gain_training = 0.0;
  std::optional<Interval> gain;  ///< on unseen folds; none when the training gain is already too small
  double p =
      1.0;  ///< not adjusted: paired errors on unseen folds, or sizes against their covariance, the smaller twice
  double p_paired = 1.0;     ///< by the errors alone
  bool identifiable = true;  ///< false: the model's own parameters can take its place exactly
};

/// Between ranks: without what all of them know, the hypothesis and the model's equation.
void pack(Bytes& bytes, const Trial& trial);
void unpack(BytesReader& from, Trial& trial);

class LogSearch {
 public:
  /// As many are enough to search with; a fit ends on all rows.
  static constexpr std::size_t kFewRows = 5000;
  static constexpr double kPieceSeconds = 2.0;
  /// The same of a log so short that it would be few of them [s].
  static double pieceSeconds(const ActuatorRows& rows) {
    constexpr double kPieces = 100.0;  // of the whole log at least
    return std::min(kPieceSeconds, static_cast<double>(rows.rows()) * rows.step / kPieces);
  }

  /// All arguments must outlive it. \param training  blocks; \param base, data  of the model.
  LogSearch(const ActuatorBase& base, const ActuatorData& data, std::vector<Block> training,
            const LogDiagnosisOptions& options);

  /// The base with these effects, started from `near` or, without one, by a global search over v_s and delta.
  Fitted fit(const std::vector<const ActuatorEffect*>& effects, const Fitted* near) const;
  /// The same from the values of a model file.
  Fitted fitFrom(const std::vector<const ActuatorEffect*>& effects, std::span<const Estimate> values) const;
  void validate(Fitted& fitted) const { validate(fitted, {*fitted.model, fitted.theta}); }

  /// Errors of the model refitted to other blocks, by a few steps from where it is. \param at  the model there
  Eigen::VectorXd refittedResidual(const Fitted& fitted, const std::vector<Block>& blocks,
                                   const RowEvaluation& at) const;

  /// Every hypothesis on top of `base` (validated first where it is not), in their order; on the threads of all ranks.
  /// \param near  another model where a search may begin, too: without one of its causes the others may have left
  /// their places to stand in for it.
  std::vector<Trial> tryAll(Fitted base, const std::vector<Hypothesis>& hypotheses, const Fitted* near = nullptr) const;

  /// True when `rival` cannot take the place of `winner`: in a model with both, the winner is significant, and the
  /// rival adds next to nothing (encompassing: Mizon & Richard 1986) or takes little from it. Both on top of the same
  /// model.
  bool encompasses(const Trial& winner, const Trial& rival) const;

  /// The model without one of its effects.
  Fitted without(const Fitted& fitted, std::size_t effect) const;
  /// The model with something beside it that is no cause. \param near  another model where a search may begin, too.
  Fitted beside(const Fitted& fitted, const Hypothesis& other, const Fitted* near = nullptr) const;

  /// Squared errors of a model on pieces of any blocks.
  GroupErrors errors(const Fitted& fitted, const std::vector<Block>& blocks,
                     double piece_seconds = kPieceSeconds) const;
  /// The same of errors that are known, shape (rows).
  GroupErrors errors(const Eigen::VectorXd& residual, const std::vector<Block>& blocks, double piece_seconds) const;
  /// What a model adds to one that it contains, on pieces of any blocks, over the rows that both count.
  /// \param rest, full  errors of the two, shape (rows)
  Nested added(const Eigen::VectorXd& rest, const Eigen::VectorXd& full, const std::vector<Block>& blocks,
               double piece_seconds = kPieceSeconds) const;
  /// The model refitted to some blocks, which moves `fitted` there; its covariance.
  Eigen::MatrixXd refit(Fitted& fitted, const std::vector<Block>& blocks) const;

  const ActuatorBase& base() const { return base_; }
  const ActuatorData& data() const { return data_; }
  const std::vector<Block>& training() const { return training_; }
  double step() const { return data_.rows.step; }  ///< [s] from row to row
  std::vector<Block> pieces(const std::vector<Block>& blocks, double seconds = kPieceSeconds) const;

 private:
  void validate(Fitted& fitted, const RowEvaluation& at) const;
  Trial tryOne(const Fitted& base, const Hypothesis& hypothesis, const Fitted* near) const;
  /// A model of the rows that are enough to search with.
  struct Rough {
    std::shared_ptr<const ActuatorRegression> model;
    std::span<const Block> blocks;
  };
  Rough roughly(std::shared_ptr<const ActuatorRegression> model) const;
  struct Start {
    double cost;  ///< that it promises
    std::vector<double> theta;
  };
  /// With the best coefficients, the most promising first. \param always  false: where few are to be tried none
  /// promises anything
  std::vector<Start> ranked(const Rough& rough, const std::vector<std::vector<double>>& starts, bool always) const;
  /// From each start, the most promising ones to the end. \param base  one of them has to promise to leave less than
  /// that, or there is no fit; null: any will do
  Fitted fitFromStarts(std::shared_ptr<const ActuatorRegression> model, const std::vector<std::vector<double>>& starts,
                       const Fitted* base = nullptr) const {
    return fitFromStarts(model, roughly(model), starts, base);
  }
  Fitted fitFromStarts(std::shared_ptr<const ActuatorRegression> model, const Rough& rough,
                       const std::vector<std::vector<double>>& starts, const Fitted* base) const;
  /// Indices of the few starts that leave least with their shapes as they are; all where there are no more.
  std::vector<std::size_t> bestStarts(const Rough& rough, const std::vector<std::vector<double>>& starts) const;
  /// The start with another v_s and delta, when they alone already fit better than those of `base`: the Stribeck curve
  /// of a model that lacks something may lie far from the true one.
  std::optional<std::vector<double>> otherStribeck(const Rough& rough, const std::vector<double>& start) const;
  /// One effect after the other, each from its own starts.
  Fitted fitInTurn(const std::vector<const ActuatorEffect*>& effects) const;
  void refineScanned(Fitted& fitted, const std::vector<std::vector<double>>& starts) const;
  std::shared_ptr<const ActuatorRegression> makeModel(const std::vector<const ActuatorEffect*>& effects) const;

  ActuatorBase base_;
  const ActuatorData& data_;
  std::vector<Block> training_;
  std::vector<std::vector<Block>> folds_;
  const LogDiagnosisOptions& options_;
  double training_rows_ = 0.0;
  std::optional<FewRows> few_;  ///< of a long log
};

}  // namespace simgap
