// Stand-in for Teensy's Wire library; see Arduino.h here.
#pragma once

#include <Arduino.h>

class TwoWire {
 public:
  void begin();
  void setClock(uint32_t frequency_hz);
};
extern TwoWire Wire, Wire1;
