/// \file
/// Joint positions as bytes and back, between ranks (bytes.h).
#pragma once

#include "simgap/core/bytes.h"
#include "simgap/core/rotation.h"

namespace simgap {

inline void pack(Bytes& bytes, const JointPosition& joint) {
  for (const double component : joint.rotation.coeffs()) pack(bytes, component);
  pack(bytes, joint.angle);
}
inline void unpack(BytesReader& from, JointPosition& joint) {
  for (double& component : joint.rotation.coeffs()) unpack(from, component);
  unpack(from, joint.angle);
}

}  // namespace simgap
