// The arm in 3-D: frames and paths of each state, made of the tables of a run.
#include "report/poses/arm_scene.h"

#include <gtest/gtest.h>

#include "report/result_folder.h"

namespace simgap {
namespace {

/// Two bodies and one muscle, in one pose and two states.
class SceneOfTwoBodies : public testing::Test {
 protected:
  SceneOfTwoBodies() : folder_(Json::object()) {
    const RunDirectory& directory = folder_.directory();
    directory.write("arm_bodies.csv",
                    "set,pose,state,body,x_m,y_m,z_m,qw,qx,qy,qz\n"
                    "validation,p1,measured,humerus,0,0,0.123456,1,0,0,0\n"
                    "validation,p1,measured,forearm,0,0,-0.3,1,0,0,0\n"
                    "validation,p1,model,humerus,0,0,0,1,0,0,0\n"
                    "validation,p1,model,forearm,0,0,-0.3,0.8,0.6,0,0\n");
    directory.write("arm_parts.csv",
                    "body,shape,radius_m,length_m,size_x_m,size_y_m,size_z_m,x_m,y_m,z_m,axis_x,axis_y,axis_z\n"
                    "forearm,cylinder,0.02,0.3,,,,0,0,-0.15,0,0,1\n");
    directory.write("arm_muscles.csv",
                    "set,pose,state,muscle,x_m,y_m,z_m,tension_N\n"
                    "validation,p1,model,biceps,0,0,0.1,12.345\n"
                    "validation,p1,model,biceps,0.02,0,-0.2,12.345\n");
  }
  std::optional<PageScene> scene(std::vector<ScenePose> poses) const {
    return armScene(ResultFiles(folder_.directory().path()), std::move(poses));
  }
  test::ResultFolder folder_;
};

TEST_F(SceneOfTwoBodies, HasAFramePerBodyAndAPathPerMuscleInEachState) {
  const auto made = scene({{"validation", "p1", {{"model", "3.0° off"}}}});
  ASSERT_TRUE(made);
  const Json& scene = made->scene;
  EXPECT_EQ(scene["bodies"], Json({"humerus", "forearm"}));
  EXPECT_EQ(scene["muscles"], Json({"biceps"}));
  EXPECT_EQ(scene["most_tension"], 12.345);
  const Json& states = scene["poses"][0]["states"];
  EXPECT_EQ(states["measured"]["bodies"][0], Json({0.0, 0.0, 0.1235, 1.0, 0.0, 0.0, 0.0}));
  EXPECT_EQ(states["model"]["bodies"][1], Json({0.0, 0.0, -0.3, 0.8, 0.6, 0.0, 0.0}));
  EXPECT_EQ(states["model"]["text"], "3.0° off");
  EXPECT_EQ(states["model"]["paths"], Json::parse("[[0, 12.35, 0, 0, 0.1, 0.02, 0, -0.2]]"));
  EXPECT_FALSE(states["measured"].contains("paths")) << "a measured pose has no muscles";
}

TEST_F(SceneOfTwoBodies, PartsNameTheirBodyByItsPlace) {
  const Json part = scene({{"validation", "p1", {{"model", ""}}}})->scene["parts"][0];
  EXPECT_EQ(part["body"], 1);
  EXPECT_EQ(part["shape"], "cylinder");
  EXPECT_EQ(part["length"], 0.3);
}

TEST_F(SceneOfTwoBodies, ThereIsNoneWithoutAPose) { EXPECT_FALSE(scene({})); }

TEST_F(SceneOfTwoBodies, SaysHowManyPosesItLeavesOut) {
  const std::vector<ScenePose> many(kMostScenePoses + 20, {"validation", "p1", {{"model", ""}}});
  const auto made = scene(many);
  EXPECT_EQ(made->scene["poses"].size(), kMostScenePoses);
  EXPECT_NE(made->note.find("The 100 worst of 120 poses."), std::string::npos);
}

}  // namespace
}  // namespace simgap
