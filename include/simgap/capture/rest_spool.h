/// \file
/// The rests of a recording of any length.
#pragma once

#include <cstddef>

#include "simgap/capture/capture_files.h"
#include "simgap/capture/steady_poses.h"

namespace simgap {

/// Rests of the same joints and shafts, in an unnamed file of the system: memory holds none of them. First all are
/// added, then any is read.
class RestSpool {
 public:
  void add(const SteadyPose& rest);
  std::size_t size() const { return size_; }
  SteadyPose at(std::size_t number) const;

 private:
  TextSpool records_;
  std::size_t record_ = 0;  ///< bytes of one, the same for all
  std::size_t size_ = 0;
};

}  // namespace simgap
