// Virtual time. Only waiting moves it on, and whoever waits is interrupted by what comes meanwhile.
#pragma once

#include <stdint.h>

namespace proof {

class Clock {
 public:
  virtual uint64_t now_us() const = 0;
  // The main loop waits: sampling ticks come in it, the card may lose its contact, the power may
  // go.
  virtual void pass(uint64_t us) = 0;
  // The power is gone: nothing that follows has any effect.
  virtual bool dead() const = 0;
  // The file is about to be closed.
  virtual void closing() = 0;

 protected:
  ~Clock() = default;
};

}  // namespace proof
