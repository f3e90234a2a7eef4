/// \file
/// What the pages of calibrate and validate share: errors per pose, from errors.csv.
#pragma once

#include <string>
#include <vector>

#include "arm_scene.h"
#include "simgap/report/html/page.h"
#include "simgap/report/html/result_files.h"

namespace simgap {

/// errors.csv: a row per pose with its status, and the error of every joint in every state.
class PoseErrorTables {
 public:
  /// \param states  "before", "after"; one empty state: the columns have none (<joint>_error_deg, status)
  /// \param set  of all poses; empty: the column `set` says it
  PoseErrorTables(const CsvTable& table, std::vector<std::string> states, std::string set);

  std::vector<std::string> sets() const;  ///< in the order of the file
  /// Bars per pose, worst first: "before" pale, the last state full.
  Chart chart(const std::string& set) const;
  /// The last set first, in each the worst pose of the last state first; poses without an error before all.
  std::vector<ScenePose> scenePoses() const;
  Table table(bool folded) const;  ///< in the order of scenePoses

 private:
  struct Row {
    std::string set, pose;
    std::vector<std::string> status;          ///< shape (states)
    std::vector<std::vector<double>> errors;  ///< shape (states, joints) [deg], [mm]; NaN: the pose is invalid
    std::string slack;                        ///< muscles
  };
  std::vector<Row> worstFirst() const;
  std::string said(const Row& row, std::size_t state) const;

  std::vector<std::string> states_, joints_;
  std::vector<Row> rows_;
};

}  // namespace simgap
