// MuJoCo refuses another word than these (the tables of its XML reader). A reader that took its own default for one
// that is mistyped would make another robot of the file: `angle="radians"` is no radian.
#include "mjcf_keywords.h"

#include <algorithm>
#include <array>
#include <vector>

namespace simgap {
namespace {

using KeywordList = std::span<const std::string_view>;

constexpr std::array<std::string_view, 2> kBools = {"false", "true"};
constexpr std::array<std::string_view, 3> kTriples = {"false", "true", "auto"};
constexpr std::array<std::string_view, 2> kAngles = {"degree", "radian"};
constexpr std::array<std::string_view, 2> kCoordinates = {"local", "global"};
constexpr std::array<std::string_view, 2> kFlags = {"enable", "disable"};
constexpr std::array<std::string_view, 4> kJoints = {"free", "ball", "slide", "hinge"};
constexpr std::array<std::string_view, 9> kGeoms = {"plane",    "hfield", "sphere", "capsule", "ellipsoid",
                                                    "cylinder", "box",    "mesh",   "sdf"};
constexpr std::array<std::string_view, 5> kSites = {"sphere", "capsule", "ellipsoid", "cylinder", "box"};
constexpr std::array<std::string_view, 2> kFluids = {"none", "ellipsoid"};
constexpr std::array<std::string_view, 6> kDynamics = {"none", "integrator", "filter", "filterexact", "muscle", "user"};
constexpr std::array<std::string_view, 4> kGains = {"fixed", "affine", "muscle", "user"};
constexpr std::array<std::string_view, 4> kBiases = {"none", "affine", "muscle", "user"};
constexpr std::array<std::string_view, 4> kIntegrators = {"Euler", "RK4", "implicit", "implicitfast"};
constexpr std::array<std::string_view, 3> kSolvers = {"PGS", "CG", "Newton"};
constexpr std::array<std::string_view, 2> kCones = {"pyramidal", "elliptic"};
constexpr std::array<std::string_view, 3> kJacobians = {"dense", "sparse", "auto"};

struct KeywordRow {
  std::string_view tag;  ///< empty: any
  std::string_view attribute;
  KeywordList words;
};

const std::vector<KeywordRow>& keywordRows() {
  static const std::vector<KeywordRow> rows = {
      {"compiler", "angle", kAngles},
      {"compiler", "coordinate", kCoordinates},
      {"compiler", "inertiafromgeom", kTriples},
      {"compiler", "autolimits", kBools},
      {"compiler", "balanceinertia", kBools},
      {"compiler", "strippath", kBools},
      {"compiler", "fitaabb", kBools},
      {"compiler", "fusestatic", kBools},
      {"compiler", "discardvisual", kBools},
      {"compiler", "usethread", kBools},
      {"compiler", "alignfree", kBools},
      {"compiler", "saveinertial", kBools},
      {"option", "integrator", kIntegrators},
      {"option", "solver", kSolvers},
      {"option", "cone", kCones},
      {"option", "jacobian", kJacobians},
      {"joint", "type", kJoints},
      {"geom", "type", kGeoms},
      {"geom", "shellinertia", kBools},
      {"geom", "fluidshape", kFluids},
      {"site", "type", kSites},
      {"body", "mocap", kBools},
      {"general", "dyntype", kDynamics},
      {"general", "gaintype", kGains},
      {"general", "biastype", kBiases},
      {"", "actearly", kBools},
      {"", "active", kBools},
      {"", "actuatorgravcomp", kBools},
      {"", "limited", kTriples},
      {"", "ctrllimited", kTriples},
      {"", "forcelimited", kTriples},
      {"", "actlimited", kTriples},
      {"", "actuatorfrclimited", kTriples},
      {"freejoint", "align", kTriples},
  };
  return rows;
}

}  // namespace

KeywordList mjcfKeywords(std::string_view tag, std::string_view attribute) {
  if (tag == "flag") return kFlags;
  const auto row = std::ranges::find_if(
      keywordRows(), [&](const KeywordRow& r) { return r.attribute == attribute && (r.tag.empty() || r.tag == tag); });
  return row == keywordRows().end() ? KeywordList() : row->words;
}

}  // namespace simgap
