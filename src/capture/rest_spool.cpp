#include "simgap/capture/rest_spool.h"

#include <cassert>

#include "simgap/core/position_bytes.h"

namespace simgap {
namespace {

/// What a record holds, in its order.
template <class Rest, class Each>
void eachField(Rest& rest, const Each& each) {
  each(rest.first_frame);
  each(rest.last_frame);
  each(rest.start);
  each(rest.end);
  each(rest.samples);
  each(rest.joints);
  each(rest.spread);
  each(rest.shafts);
}

}  // namespace

void RestSpool::add(const SteadyPose& rest) {
  Bytes bytes;
  eachField(rest, [&](const auto& field) { pack(bytes, field); });
  assert(size_ == 0 || bytes.size() == record_);
  record_ = bytes.size();
  records_.add(bytes);
  ++size_;
}

SteadyPose RestSpool::at(std::size_t number) const {
  assert(number < size_);
  Bytes bytes(record_, 0);
  records_.read(number * record_, bytes);
  BytesReader reader{bytes};
  SteadyPose rest;
  eachField(rest, [&](auto& field) { unpack(reader, field); });
  return rest;
}

}  // namespace simgap
