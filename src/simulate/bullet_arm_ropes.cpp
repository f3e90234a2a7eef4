// Lines that collide with the skeleton: the soft body of 000 eq. 7. A chain of nodes in a world of Bullet's soft
// bodies, in which the parts of all bodies stand as obstacles that move with the arm:
//
//     L = sum_i |N_i - N_i-1| + |A_2 - N_n|,   N_0 = A_1                                                  000 eq. 7
//
// The nodes say where the line runs. What it does to the arm follows from its tension F, which the cord has: a line
// without mass pulls at its ends along their stretches, and where it bends about a body it presses on it with
// F (u_i+1 - u_i), u_i being the direction of stretch i. Friction between line and bone is left out.
#include <BulletSoftBody/btSoftBody.h>
#include <BulletSoftBody/btSoftBodyHelpers.h>
#include <BulletSoftBody/btSoftBodyRigidBodyCollisionConfiguration.h>
#include <BulletSoftBody/btSoftRigidDynamicsWorld.h>

#include <cmath>
#include <numbers>

#include "bullet_arm_state.h"

namespace simgap {
namespace {

constexpr int kNodes = 32;            // of a line, with its ends
constexpr double kMargin = 5e-4;      // [m] a node stays so far from a part: half of a line's diameter
constexpr double kVoxel = 2e-3;       // [m] of the distance fields that Bullet makes of parts
constexpr double kTightening = 0.97;  // of its length is what a line contracts to: it is always taut
constexpr double kDamping = 0.1;      // of the nodes' velocities, per step
constexpr int kSweeps = 4;            // over the constraints of a step

/// Bullet knows no ellipsoid: its hull.
std::unique_ptr<btConvexHullShape> ellipsoid(const Eigen::Vector3d& semi_axes) {
  constexpr int kRings = 16, kMeridians = 24;
  auto hull = std::make_unique<btConvexHullShape>();
  for (int ring = 0; ring <= kRings; ++ring) {
    const double polar = std::numbers::pi * ring / kRings;
    for (int m = 0; m < kMeridians; ++m) {
      const double around = 2.0 * std::numbers::pi * m / kMeridians;
      const Eigen::Vector3d unit(std::sin(polar) * std::cos(around), std::sin(polar) * std::sin(around),
                                 std::cos(polar));
      hull->addPoint(toBullet(Eigen::Vector3d(semi_axes.cwiseProduct(unit))), false);
    }
  }
  hull->recalcLocalAabb();
  return hull;
}

std::unique_ptr<btConvexShape> shapeOf(const Part& part) {
  switch (part.shape) {
    case Part::Shape::kSphere:
      return std::make_unique<btSphereShape>(part.radius);
    case Part::Shape::kCylinder:
      return std::make_unique<btCylinderShapeZ>(btVector3(part.radius, part.radius, 0.5 * part.length));
    case Part::Shape::kCapsule:
      return std::make_unique<btCapsuleShapeZ>(part.radius, part.length);
    case Part::Shape::kBox:
      return std::make_unique<btBoxShape>(toBullet(Eigen::Vector3d(0.5 * part.size)));
    case Part::Shape::kEllipsoid:
      return ellipsoid(part.size);
    case Part::Shape::kInertia:
      break;
  }
  return nullptr;
}

btTransform placeOf(const Part& part) {
  const bool round = part.shape == Part::Shape::kCylinder || part.shape == Part::Shape::kCapsule;
  const Eigen::Quaterniond turn = round ? rotationBetween(Eigen::Vector3d::UnitZ(), part.axis) : part.orientation;
  return btTransform(toBullet(turn), toBullet(part.position));
}

btTransform placeOf(const BodyInWorld& frame) {
  const Eigen::Quaterniond turn(frame.rotation);
  return btTransform(toBullet(turn), toBullet(frame.origin));
}

/// The parts of a body, as one obstacle.
struct Obstacle {
  std::vector<std::unique_ptr<btConvexShape>> parts;
  btCompoundShape shape;
  std::unique_ptr<btRigidBody> body;

  explicit Obstacle(const Body& of) {
    for (const Part& part : of.parts) {
      std::unique_ptr<btConvexShape> solid = shapeOf(part);
      if (!solid) continue;
      if (part.shape == Part::Shape::kBox || part.shape == Part::Shape::kCylinder) solid->setMargin(1e-4);
      shape.addChildShape(placeOf(part), solid.get());
      parts.push_back(std::move(solid));
    }
    body = std::make_unique<btRigidBody>(btRigidBody::btRigidBodyConstructionInfo(0.0, nullptr, &shape));
    body->setCollisionFlags(body->getCollisionFlags() | btCollisionObject::CF_KINEMATIC_OBJECT);
    body->setActivationState(DISABLE_DEACTIVATION);
  }
};

}  // namespace

struct BulletArm::Ropes {
  struct Rope {
    std::array<Attachment, 2> ends;
    std::unique_ptr<btSoftBody> chain;
    std::array<int, kNodes> touched;  ///< the body that a node touched last; -1: none yet
  };

  Ropes() : world(&dispatcher, &broadphase, &solver, &configuration) {
    btSoftBodyWorldInfo& info = world.getWorldInfo();
    info.m_gravity.setZero();
    info.air_density = info.water_density = 0.0;
    info.m_sparsesdf.setDefaultVoxelsz(kVoxel);
    info.m_sparsesdf.Reset();
    world.setGravity(btVector3(0.0, 0.0, 0.0));
  }
  Ropes(const Ropes&) = delete;
  Ropes& operator=(const Ropes&) = delete;
  ~Ropes() {
    for (const Rope& rope : ropes) world.removeSoftBody(rope.chain.get());
    for (const auto& obstacle : obstacles) world.removeRigidBody(obstacle->body.get());
  }

  void addBody(const Body& body) {
    obstacles.push_back(std::make_unique<Obstacle>(body));
    obstacles.back()->body->setUserIndex(static_cast<int>(obstacles.size()) - 1);
    world.addRigidBody(obstacles.back()->body.get());
  }

  static btVector3 placed(const Attachment& end, std::span<const BodyInWorld> frames) {
    return toBullet(frames[end.body] * end.point);
  }

  void addRope(const std::array<Attachment, 2>& ends, std::span<const BodyInWorld> frames) {
    Rope rope{ends, nullptr, {}};
    rope.touched.fill(-1);
    constexpr int kBothEndsFixed = 3;
    rope.chain.reset(btSoftBodyHelpers::CreateRope(world.getWorldInfo(), placed(ends[0], frames),
                                                   placed(ends[1], frames), kNodes - 2, kBothEndsFixed));
    btSoftBody& chain = *rope.chain;
    chain.setTotalMass(0.01);
    chain.getCollisionShape()->setMargin(kMargin);
    chain.m_cfg.collisions = btSoftBody::fCollision::SDF_RS;
    chain.m_cfg.piterations = kSweeps;
    chain.m_cfg.kDP = kDamping;
    chain.m_cfg.kDF = 0.0;
    chain.setActivationState(DISABLE_DEACTIVATION);
    chain.updateConstants();
    chain.m_bUpdateRtCst = false;  // the lengths of links are set by tighten()
    world.addSoftBody(&chain);
    ropes.push_back(std::move(rope));
  }

  /// All links of one length, a little shorter than they are: the chain contracts to the shortest way past the bones.
  static void tighten(btSoftBody& chain) {
    double length = 0.0;
    for (int i = 1; i < chain.m_nodes.size(); ++i) length += (chain.m_nodes[i].m_x - chain.m_nodes[i - 1].m_x).length();
    const double link = kTightening * length / (chain.m_nodes.size() - 1);
    for (int i = 0; i < chain.m_links.size(); ++i) {
      chain.m_links[i].m_rl = link;
      chain.m_links[i].m_c1 = link * link;
    }
  }

  void step(std::span<const BodyInWorld> frames, double step) {
    for (std::size_t b = 0; b < obstacles.size(); ++b) obstacles[b]->body->setWorldTransform(placeOf(frames[b]));
    for (Rope& rope : ropes) {
      for (int end = 0; end < 2; ++end) {
        btSoftBody::Node& node = rope.chain->m_nodes[end == 0 ? 0 : kNodes - 1];
        node.m_x = node.m_q = placed(rope.ends[end], frames);
        node.m_v.setZero();
      }
      tighten(*rope.chain);
    }
    world.stepSimulation(step, /*maxSubSteps=*/0);
    for (Rope& rope : ropes) {
      const auto& contacts = rope.chain->m_rcontacts;
      const btSoftBody::Node* first = &rope.chain->m_nodes[0];
      for (int c = 0; c < contacts.size(); ++c) {
        rope.touched[contacts[c].m_node - first] = contacts[c].m_cti.m_colObj->getUserIndex();
      }
    }
  }

  btSoftBodyRigidBodyCollisionConfiguration configuration;
  btCollisionDispatcher dispatcher{&configuration};
  btDbvtBroadphase broadphase;
  btSequentialImpulseConstraintSolver solver;
  btSoftRigidDynamicsWorld world;
  std::vector<std::unique_ptr<Obstacle>> obstacles;  ///< shape (bodies)
  std::vector<Rope> ropes;
};

void BulletArm::RopesDeleter::operator()(Ropes* ropes) const { delete ropes; }

/// Straight lines at first, anew for every pose: a world's history would show in the last bits.
void BulletArm::layRopes() {
  if (rope_of_.empty()) return;
  ropes_.reset(new Ropes);
  for (const Body& body : bodies_) ropes_->addBody(body);
  for (std::size_t m = 0; m < muscles_.size(); ++m) {
    if (rope_of_[m] >= 0) ropes_->addRope(muscles_[m].attachments, frames_);
  }
}

void BulletArm::moveRopes() { ropes_->step(frames_, options_.step); }

BulletArm::PathState BulletArm::followRope(int index) {
  const Ropes::Rope& rope = ropes_->ropes[index];
  touches_.clear();
  PathState state{0.0, 0.0};
  const auto node = [&](int i) {
    const btVector3& x = rope.chain->m_nodes[i].m_x;
    return Eigen::Vector3d(x.x(), x.y(), x.z());
  };
  const auto touch = [&](int body, const Eigen::Vector3d& at, const Eigen::Vector3d& slope) {
    touches_.push_back({body, at - frames_[body].origin, slope});
  };
  Eigen::Vector3d before = Eigen::Vector3d::Zero(), here = node(0);
  for (int i = 0; i < kNodes; ++i) {
    Eigen::Vector3d after = Eigen::Vector3d::Zero(), next = here;
    if (i + 1 < kNodes) {
      next = node(i + 1);
      const double stretch = (next - here).norm();
      if (stretch > 0.0) after = (next - here) / stretch;
      state.length += stretch;
    }
    const int body = i == 0 ? rope.ends[0].body : i + 1 == kNodes ? rope.ends[1].body : rope.touched[i];
    if (body >= 0) touch(body, here, before - after);
    before = after;
    here = next;
  }
  for (const Touch& t : touches_) {
    state.rate += t.slope.dot(Eigen::Vector3d(drift_[t.body] + spin_[t.body].cross(t.arm)));
  }
  return state;
}

}  // namespace simgap
