#include "simgap/capture/rest_spool.h"

#include <cassert>

#include "simgap/core/position_bytes.h"

namespace simgap {

void RestSpool::add(const SteadyPose& rest) {
  Bytes bytes;
  pack(bytes, rest.first_frame);
  pack(bytes, rest.last_frame);
  pack(bytes, rest.start);
  pack(bytes, rest.end);
  pack(bytes, rest.samples);
  pack(bytes, rest.joints);
  pack(bytes, rest.spread);
  pack(bytes, rest.shafts);
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
  unpack(reader, rest.first_frame);
  unpack(reader, rest.last_frame);
  unpack(reader, rest.start);
  unpack(reader, rest.end);
  unpack(reader, rest.samples);
  unpack(reader, rest.joints);
  unpack(reader, rest.spread);
  unpack(reader, rest.shafts);
  return rest;
}

}  // namespace simgap
