// Numbers from a seed: the same on every machine.
#pragma once

#include <stdint.h>

namespace proof {

// Finaliser of MurmurHash3 (A. Appleby, public domain).
inline uint32_t mixed(uint32_t x) {
  x = (x ^ (x >> 16)) * 0x85EBCA6Bu;
  x = (x ^ (x >> 13)) * 0xC2B2AE35u;
  return x ^ (x >> 16);
}

// One of many independent sequences, by index.
inline uint32_t drawn_at(uint32_t seed, uint32_t index, uint32_t channel) {
  return mixed(mixed(seed * 0x9E3779B1u + index) + channel * 0x27D4EB2Fu);
}

// One number after another.
class Draw {
 public:
  Draw(uint32_t seed, uint32_t purpose) : seed_(mixed(seed) ^ purpose * 0x9E3779B1u) {}

  uint32_t next() { return drawn_at(seed_, count_++, 0); }
  // At least `least`, below `end`.
  uint32_t between(uint32_t least, uint32_t end) { return least + next() % (end - least); }
  bool one_in(uint32_t n) { return next() % n == 0; }

 private:
  uint32_t seed_;
  uint32_t count_ = 0;
};

}  // namespace proof
