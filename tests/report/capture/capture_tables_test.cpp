#include "report/capture/capture_tables.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace simgap {
namespace {

using ::testing::ElementsAre;

const char* kPoses =
    "pose,shoulder_qw,shoulder_qx,shoulder_qy,shoulder_qz,elbow_rad\n"
    "p000,0.5,0.5,0.5,0.5,-0.5235987755982988\n"
    "p001,-1,0,0,0,0\n";

TEST(CaptureTables, PosesShowWhereTheArmRested) {
  const Json result = {{"joint_types", {{"shoulder", "spherical"}, {"elbow", "revolute"}}},
                       {"poses",
                        {{{"pose", "p000"},
                          {"start_s", 0.25},
                          {"end_s", 1.0},
                          {"samples", 8},
                          {"spread_deg", {{"shoulder", 0.01}, {"elbow", 0.02}}}},
                         {{"pose", "p001"},
                          {"start_s", 2.0},
                          {"end_s", 3.0},
                          {"samples", 9},
                          {"spread_deg", {{"shoulder", 0.03}, {"elbow", 0.04}}}}}}};
  const Table table = poseTable(result, CsvTable::parse(kPoses, "poses.csv"));
  EXPECT_THAT(table.header, ElementsAre("pose", "from [s]", "to [s]", "samples", "shoulder [deg]", "spread",
                                        "elbow [deg]", "spread"));
  EXPECT_THAT(table.rows[0], ElementsAre("p000", "0.250", "1.000", "8", "120.00", "0.010", "-30.00", "0.020"));
  EXPECT_THAT(table.rows[1], ElementsAre("p001", "2.000", "3.000", "9", "0.00", "0.030", "0.00", "0.040"));
}

TEST(CaptureTables, AnswersSayWhatSpeaksAgainstTheGeometry) {
  Json result = {{"pairs", 40}, {"pairs_with_all_joints", 30}, {"poses", Json::array()}};
  result["geometry"]["findings"] = Json::array();
  EXPECT_EQ(captureAnswer(result, 0),
            "40 pairs: all joints in 75.0 % of them, 0 steady poses; nothing speaks against the geometry.");
  result["geometry"]["findings"] = {{{"name", "epipolar"}, {"sentence", "…"}}};
  EXPECT_THAT(captureAnswer(result, 7), testing::EndsWith("the geometry is in doubt for 1 reasons."));
}

}  // namespace
}  // namespace simgap
